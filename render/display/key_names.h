// Keys by name, for input that is a line of text: "b,m,Left,Shift+Up".
#pragma once

#include <string>
#include <vector>

#include "render/display/surface.h"

namespace ulf::render {

// Names separated by commas: a typed character (`comma` and `Space` for these two), or Left, Right, Up, Down,
// PageUp, PageDown, Home, Enter, Escape, Backspace, Delete, F1, F11; "Shift+" before them holds Shift. Throws
// Refusal for others.
std::vector<InputEvent> KeysFromNames(const std::string& names);

}  // namespace ulf::render
