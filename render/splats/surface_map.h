// The surface that a view's depth map shows, as a plane at each of its pixels: over a plane, inverse depth is
// linear in the image.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "render/proxy/view_depth_map.h"

namespace ulf::render {

// Inverse depth (along the optical axis, 1 / world units) at a ray (x, y, 1), and its change with x and y of
// the ray.
struct RayPlane {
  float inverse_depth = 0, by_x = 0, by_y = 0;
};

class SurfaceMap {
 public:
  SurfaceMap() = default;
  // Fits the planes to the pixels around each, but not across edges, which smooths the depths.
  explicit SurfaceMap(const ViewDepthMap& map);

  float step() const { return step_; }  // ViewDepthMap::step
  // Returns the plane of the pixel that shows the ray, at the ray itself; none outside the map or where the
  // depth is unknown.
  std::optional<RayPlane> At(float ray_x, float ray_y) const;

 private:
  float fx_ = 1, fy_ = 1, cx_ = 0, cy_ = 0, step_ = 0;
  cv::Mat planes_;  // CV_32FC3: inverse depth at the pixel's centre, change with each column and row
};

}  // namespace ulf::render
