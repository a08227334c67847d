// Checks a light field's poses and light, keeps what the checks find in its folder, and reports it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

#include "core/base/progress.h"
#include "core/frames/frame.h"
#include "core/light_field/folder/light_check.h"
#include "core/light_field/light_field.h"
#include "tracking/refine/pose_check.h"

namespace ulf::commands {

// The result of checking poses against the pictures (ulf info --check-poses).
struct PoseReport {
  tracking::PoseCheck check;
  double seconds = 0;           // duration of the check
  std::set<int> exchanged{};    // View::id of contradicted views whose photograph differs from its master
  std::string lapsed{};         // earlier finding that no longer holds; empty: none
  std::string not_withdrawn{};  // why the earlier finding stays in the folder; empty: it does not
  std::string not_kept{};       // why findings were not stored; empty: they were, or there are none
};
// Compares the photographs with the poses, stores the findings in the folder, and replaces with them the
// findings of `light_field` about its poses. `silent` suppresses the progress line.
PoseReport CheckedPoses(LightField& light_field, bool silent);
std::string ToText(const PoseReport& report, const LightField& light_field);
nlohmann::json ToJson(const PoseReport& report, const LightField& light_field);

// Runs CheckLight() (light_check.h) with progress, at the end of a capture and in ulf info --check-light.
LightCheck CheckLightOf(const LightField& light_field, Progress& progress);
// Stores the findings in the folder, and replaces with them the findings of `light_field` about its light.
// Warns if they cannot be stored.
void KeepLight(const LightCheck& check, LightField& light_field);
// Reports clipped pixels and changes of the light. `source` is SourceOf() the light field.
std::string ToText(const LightCheck& check, FrameSource source);
nlohmann::json ToJson(const LightCheck& check);
// Says how the light changed, with the remedy; "" if it did not.
std::string LampAdvice(const LightCheck& check, FrameSource source);
// Returns kPhotographs for imported and replayed views, which cannot be taken again; else the kind of camera.
FrameSource SourceOf(const LightField& light_field);

// Returns an array of all known faults: those of the files, and the findings of the checks.
nlohmann::json DoubtsJson(const LightField& light_field);

}  // namespace ulf::commands
