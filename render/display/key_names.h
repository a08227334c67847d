// Keys by name, for a person who is a line of text: "b,m,Left,Shift+Up".
#pragma once

#include <string>
#include <vector>

#include "render/display/surface.h"

namespace ulf::render {

// Separated by commas: a character that is typed (`comma` and `Space` for these), or Left, Right, Up, Down,
// PageUp, PageDown, Home, Enter, Escape, Backspace, Delete, F1, F11, with Shift+ before it where Shift is
// held. UsageError for others.
std::vector<InputEvent> KeysFromNames(const std::string& names);

}  // namespace ulf::render
