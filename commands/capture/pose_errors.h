// `ulf capture --truth`: the errors of a capture's camera centres against true ones after a similarity
// alignment, for all tracked frames with their live poses and for the recorded views with their final poses.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/light_field.h"

namespace ulf::commands {

struct PoseErrors {
  std::optional<TrajectoryError> live, views;
  double subject_distance = 0;  // median of the views, in the truth's unit
};

// `truth_file` is TUM's format, its times the device's. Throws Error naming file and line.
PoseErrors CompareWithTruth(const std::filesystem::path& truth_file, const std::vector<TimedPose>& live,
                            const LightField& light_field);

// In the truth's unit.
void AddTo(nlohmann::json& json, const PoseErrors& errors);

// For people: shares of the subject's distance.
std::string ToText(const PoseErrors& errors);

}  // namespace ulf::commands
