// What the checks of a light field find, kept with it and said: of its poses, of its light, and all that is
// known to be wrong.
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

// Which views' poses the pictures contradict (ulf info --check-poses).
struct PoseReport {
  tracking::PoseCheck check;
  double seconds = 0;  // that it took
  std::set<int>
      exchanged{};       // views whose poses are contradicted and whose photograph differs from its master
  std::string lapsed{};  // what an earlier check found and this one does not; empty: nothing
  std::string not_withdrawn{};  // why it stays kept all the same; empty: it does not
  std::string
      not_kept{};  // why what is wrong is not kept with the light field; empty: it is, or nothing is wrong
};
// Compares the photographs with the poses, keeps with the light field what it finds, and puts it in place of
// what `light_field` knows of its poses.
PoseReport CheckedPoses(LightField& light_field, bool silent);
std::string ToText(const PoseReport& report, const LightField& light_field);
nlohmann::json ToJson(const PoseReport& report, const LightField& light_field);

// The one verdict on the light: at the end of a capture and of ulf info --check-light.
LightCheck CheckLightOf(const LightField& light_field, Progress& progress);
// Keeps it with the light field, and puts it in place of what `light_field` knows of its light. Says where it
// cannot.
void KeepLight(const LightCheck& check, LightField& light_field);
// What was found of clipped pixels and of the lamp (ulf info --check-light).
std::string ToText(const LightCheck& check, FrameSource source);
nlohmann::json ToJson(const LightCheck& check);
// What a lamp that changed means and what to do; empty where none did. `source`: of whoever took the views.
std::string LampAdvice(const LightCheck& check, FrameSource source);
// Who took a light field's views: a camera, or nobody who still can change anything (imported, replayed).
FrameSource SourceOf(const LightField& light_field);

// All that is known to be wrong: of the files, and by the checks.
nlohmann::json DoubtsJson(const LightField& light_field);

}  // namespace ulf::commands
