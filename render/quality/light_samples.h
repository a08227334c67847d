// Points of the proxy's surface as the views that see them have recorded them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "render/quality/light_solution.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct LightSampleOptions {
  int points_per_view = 400;  // tried; their number sets the error, which falls with its root. Guessed.
  int most_points = 40000;    // in all: their number sets the time. Guessed.
  int views_per_point = 8;    // at most, of those that see it. Guessed.
  int most_asked = 64;        // views that are asked whether they see a point. Guessed.
  int size_px = 480;          // longer side of the pictures that are compared, at most: as proxies are made
  // Light outside of these is not compared: clipped, or mostly noise. Shares of white. Guessed.
  float least_light = 0.01f, most_light = 0.95f;
  // Of the log of light: what points differ by where the picture is smooth; where it is not, what a misplacement
  // by a pixel changes counts as well. Guessed.
  double smooth_error = 0.02;
};

Eigen::Vector2d HalfDiagonal(const CameraModel& camera);  // pixels

// A fifth of the points is held out. `camera_of`: of each view; `points`: how many there are. The same whatever the
// number of threads; none over a proxy without triangles.
std::vector<LightSample> SampleLight(const RenderScene& scene, const std::vector<int>& camera_of,
                                     const LightSampleOptions& options, std::size_t& points);

}  // namespace ulf::render
