// Reports merging and masking, in their own commands and at the end of a capture, and the memory of a run.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "render/masks/turntable_masks.h"
#include "render/stereo/bracket_merge.h"

namespace ulf::commands {

// Reports merged exposures in complete lines.
std::string ToText(const render::BracketReport& report);
nlohmann::json ToJson(const render::BracketReport& report);

// Reports masks of a turntable's light field in one or more lines.
std::string ToText(const render::TurntableMasks& masks);

// Returns the most memory that this process has had so far, MiB.
double PeakMemoryMib();

}  // namespace ulf::commands
