// Reports merged exposures, masks, and the memory of a run. Texts are complete lines.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/light_field/light_field.h"
#include "render/masks/moved_masks.h"
#include "render/masks/turntable_masks.h"
#include "render/stereo/bracket_merge.h"

namespace ulf::commands {

// Texts are complete lines.
std::string ToText(const render::BracketReport& report);
nlohmann::json ToJson(const render::BracketReport& report);
std::string ToText(const render::TurntableMasks& masks);
std::string ToText(const render::MovedMasks& masks, const LightField& light_field);

// Returns the most memory that this process has had so far, MiB.
double PeakMemoryMib();

}  // namespace ulf::commands
