// Runs, stores and reports the checks of a light field: of its poses, of its light, and all known faults.
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

// The views whose poses the pictures contradict (ulf info --check-poses).
struct PoseReport {
  tracking::PoseCheck check;
  double seconds = 0;           // duration of the check
  std::set<int> exchanged{};    // contradicted views whose photograph differs from its master
  std::string lapsed{};         // earlier findings that no longer hold; empty: none
  std::string not_withdrawn{};  // why they stay in the journal; empty: they do not
  std::string not_kept{};       // why findings were not stored; empty: they were, or there are none
};
// Compares the photographs with the poses, stores the findings in the light field, and replaces those of
// `light_field` about its poses.
PoseReport CheckedPoses(LightField& light_field, bool silent);
std::string ToText(const PoseReport& report, const LightField& light_field);
nlohmann::json ToJson(const PoseReport& report, const LightField& light_field);

// Judges the light, at the end of a capture and in ulf info --check-light.
LightCheck CheckLightOf(const LightField& light_field, Progress& progress);
// Stores the findings in the light field, and replaces those of `light_field` about its light. Logs if it
// cannot.
void KeepLight(const LightCheck& check, LightField& light_field);
// Reports clipped pixels and the lamp (ulf info --check-light).
std::string ToText(const LightCheck& check, FrameSource source);
nlohmann::json ToJson(const LightCheck& check);
// Explains a lamp that changed, with the remedy; empty if none did. `source` is that of the views.
std::string LampAdvice(const LightCheck& check, FrameSource source);
// Returns whether a camera took the views, or nothing can be changed any more (imported, replayed).
FrameSource SourceOf(const LightField& light_field);

// Returns all known faults: of the files, and by the checks.
nlohmann::json DoubtsJson(const LightField& light_field);

}  // namespace ulf::commands
