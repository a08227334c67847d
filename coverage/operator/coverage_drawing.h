// Draws the coverage map with OpenCV, in the colours of palette.h: a chart of directions, and the painted
// sphere over the camera's own image (thesis, figure 3-1).
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/error_map.h"

namespace ulf::coverage {

struct CoverageMapPicture {
  int width = 960;  // px; the height follows
  // The current camera; none: distances are compared with the median.
  std::optional<Rigid3> cam_from_world = std::nullopt;
};

// All pictures are 8-bit B, G, R; charts say so where nothing is recorded yet. DrawCoverageMap() and
// DrawOverlay() paint the map anew on a finer grid for their colours, which takes some tenths of a second.
// What the chart shows as open, its share and its numbered holes are those of `map` itself, as `ulf info`
// tells them.

// Draws a chart of azimuth to the right and elevation upwards, in degrees about the first recorded direction,
// over the cap (or what was recorded, without one) and a margin.
cv::Mat DrawCoverageMap(const CoverageMap& map, const CoverageMapPicture& picture = {});

// Draws the same directions with the error that was measured in them, and the letter of its cause (overlay.h)
// where a recorded view covers a direction and the pictures are worse than `goal_db` all the same.
cv::Mat DrawErrorMap(const CoverageMap& map, const ErrorMap& errors, double goal_db,
                     const CoverageMapPicture& picture = {});

// Draws the overlay (overlay.h) on a copy of `live`, which `camera` took from `cam_from_world`. The safety
// rectangle is white while it holds the sphere, red otherwise.
cv::Mat DrawOverlay(const cv::Mat& live, const CameraModel& camera, const Rigid3& cam_from_world,
                    const CoverageMap& map);

}  // namespace ulf::coverage
