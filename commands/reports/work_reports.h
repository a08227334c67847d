// What merging and masking have come to: said by the command that does it, and by a capture at its end.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "render/masks/turntable_masks.h"
#include "render/stereo/bracket_merge.h"

namespace ulf::commands {

// Merged exposures; complete lines.
std::string ToText(const render::BracketReport& report);
nlohmann::json ToJson(const render::BracketReport& report);

// Masks of a turntable's light field; one or more lines.
std::string InWords(const render::TurntableMasks& masks);

}  // namespace ulf::commands
