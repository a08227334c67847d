// Reports a finished capture as text for people and as JSON for programs.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/light_field.h"
#include "coverage/session/capture_summary.h"

namespace ulf::commands {

// Returns complete lines. `tracked` is the number of frames that got a pose; `dir` is the light field's
// folder, which the text names in commands to type.
std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked, const std::string& dir);
// Adds one key for each figure of the summary to the JSON object.
void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked);

// Says why a capture recorded no view, by the commonest reason, and names the remedy.
std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked);

// Says why a session recorded hardly anything, by the commonest reason, and names the remedy: if at least
// half of its frames were refused, and less than a fifth of those in uncovered directions recorded. Reasons
// that say that the camera does not look at the subject count as one. Else, or if the cap is covered: "".
std::string FewRecordedReason(const coverage::CaptureSummary& summary);

// The errors of camera centres against true ones after a similarity alignment (`ulf capture --truth`): `live`
// of all tracked frames with the poses given live, `views` of the recorded views with their final poses; none
// if CompareTrajectories() returns none.
struct PoseErrors {
  std::optional<TrajectoryError> live, views;
  double subject_distance = 0;  // median over the views, in the truth's unit; 0: unknown
};

// `truth` has times of the device's clock; poses within 2 ms are compared.
PoseErrors CompareWithTruth(const std::vector<TimedPose>& truth, const std::vector<TimedPose>& live,
                            const LightField& light_field);
void AddTo(nlohmann::json& json, const PoseErrors& errors);  // in the truth's unit; null if unknown
std::string ToText(const PoseErrors& errors);                // in per cent of the subject's distance

}  // namespace ulf::commands
