// Masks of a turntable's light field, made and written: what `ulf mask` does, and a capture at its end.
#pragma once

#include <filesystem>
#include <string>

#include "render/masks/turntable_masks.h"

namespace ulf::commands {

// Makes the masks of all views and writes them into the light field, with a progress line. Throws as
// MakeTurntableMasks() and LightFieldWriter do; then the light field is as it was.
render::TurntableMasks WriteTurntableMasks(const std::filesystem::path& dir,
                                           const render::TurntableMaskOptions& options = {});

// What came out, for people: one or more lines.
std::string InWords(const render::TurntableMasks& masks);

}  // namespace ulf::commands
