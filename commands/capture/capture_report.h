// The report of a finished capture: text for people, JSON for programs.
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

// `tracked` counts frames that got a pose. The text has complete lines. `dir` is the light field, for
// commands in the text.
std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked, const std::string& dir);
void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked);

// Says for captures without a view why nothing was recorded, by the commonest reason, and the remedy.
std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked);

// Returns the commonest reason and its remedy for a light field with views, if most frames were refused and
// few or none of those in uncovered directions were recorded. Reasons for a camera that does not look at the
// subject count as one. The text is empty if there is no such reason.
std::string FewRecordedReason(const coverage::CaptureSummary& summary);

// The errors of a capture's camera centres against true ones after a similarity alignment (`ulf capture
// --truth`), for all tracked frames with their live poses and for the recorded views with their final poses.
struct PoseErrors {
  std::optional<TrajectoryError> live, views;
  double subject_distance = 0;  // median of the views, in the truth's unit
};

// The times of `truth` are by the device's clock.
PoseErrors CompareWithTruth(const std::vector<TimedPose>& truth, const std::vector<TimedPose>& live,
                            const LightField& light_field);
void AddTo(nlohmann::json& json, const PoseErrors& errors);  // in the truth's unit
std::string ToText(const PoseErrors& errors);                // shares of the subject's distance

}  // namespace ulf::commands
