// Compares a light field's poses with true ones: as recorded, before refining, and after. Each set is aligned
// with the truth by a similarity of its own; lengths are in the truth's unit.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/light_field.h"
#include "tracking/refine/refine_result.h"

namespace ulf::tracking {

struct LightFieldErrors {
  std::string truth_name;
  std::optional<TrajectoryError> recorded, before, after;  // recorded: none if it would be the same as before
  double distance = 0;  // median distance of the true cameras from the middle of the refined points
};

// Pairs views with the truth by the device's times, within half of the time between two true poses and
// `most_apart_s` (half a frame at 30 Hz). Throws Error for fewer than three pairs, or pairs on a line.
LightFieldErrors CompareWithTruth(const LightField& before, const RefineResult& result,
                                  const std::vector<TimedPose>& truth, const std::string& truth_name,
                                  double most_apart_s = 1.0 / 60);

nlohmann::ordered_json ToJson(const LightFieldErrors& errors);
std::string ToText(const LightFieldErrors& errors);

}  // namespace ulf::tracking
