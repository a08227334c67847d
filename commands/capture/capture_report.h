// The report of a finished capture: text for people, JSON for programs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/light_field.h"
#include "coverage/session/capture_summary.h"

namespace ulf::commands {

// `tracked`: frames that got a pose. Complete lines.
// `dir`: the light field, for commands that it names.
std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked, const std::string& dir);
void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked);

// Why nothing was recorded, and what to do: the commonest reason. For captures that recorded no view.
std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked);

// When most frames were refused and few or none of those that were not covered already were recorded: the
// commonest reason and what to do. Reasons that mean that the camera does not look at the subject count as
// one. Empty: no such reason. For light fields that hold views.
std::string FewRecordedReason(const coverage::CaptureSummary& summary);

// `ulf capture --truth`: the errors of a capture's camera centres against true ones after a similarity
// alignment, for all tracked frames with their live poses and for the recorded views with their final poses.
struct PoseErrors {
  std::optional<TrajectoryError> live, views;
  double subject_distance = 0;  // median of the views, in the truth's unit
};

// The times of `truth` are the device's.
PoseErrors CompareWithTruth(const std::vector<TimedPose>& truth, const std::vector<TimedPose>& live,
                            const LightField& light_field);
void AddTo(nlohmann::json& json, const PoseErrors& errors);  // in the truth's unit
std::string ToText(const PoseErrors& errors);                // shares of the subject's distance

}  // namespace ulf::commands
