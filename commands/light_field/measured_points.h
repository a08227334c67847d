// Measures the points of a light field anew for exports that hold points.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "core/light_field/light_field.h"

namespace ulf::commands {

struct MeasuredPoints {
  bool done = false;
  std::size_t points = 0;    // that were measured
  bool kept_points = false;  // no point was found; the light field's own stay
  double pose_error_px = 0;  // TriangulationResult::pose_error_px
  std::size_t unread = 0;    // number of photographs that could not be read
};

// Replaces the points by those that the photographs show under the light field's poses.
MeasuredPoints MeasurePointsAnew(LightField& light_field,
                                 const std::function<void(double share, const std::string& stage)>& progress);

// Returns a sentence on what it means that an export holds no points, and what to do. `measured` was not done
// if known points are asked for: a capture that was killed has none.
std::string NoPointsInWords(const LightField& exported, const MeasuredPoints& measured, bool for_colmap);

// Returns sentences for people, each with a line break; empty where all is well.
std::string PointDoubtsText(const MeasuredPoints& measured);

}  // namespace ulf::commands
