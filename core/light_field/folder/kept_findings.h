// Keeps, in a light field's journal, what costly checks found, so that every command that opens the light
// field can repeat it. A finding lapses for a view whose photograph or pose is not the judged one any more.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/light_field/findings.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Returns those of `kept` that still hold, with the views for which they do. Reads parts of photographs.
std::vector<Finding> StillValid(const std::vector<KeptFinding>& kept, const LightField& light_field);

// Notes in the journal of the light field in `dir` what `check` found, replacing what it found before.
// Returns an empty string, or why that cannot be done: `dir` has no journal, cannot be written, is being
// recorded into or must be repaired first.
std::string KeepFindings(const std::filesystem::path& dir, Check check, const std::vector<Finding>& found);

}  // namespace ulf
