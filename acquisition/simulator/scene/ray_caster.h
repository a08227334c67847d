// Casts a ray through every pixel of a camera with its distortion, eight at a time, into baked textures.
//
// Each pixel gets one ray; pixels whose solid differs from a neighbour's, that something thin passes through,
// or that see a mirror or glass get four more to anti-alias edges (mip levels of the textures do that inside
// surfaces). Each tile has a list of the solids that it can show. `sway_angle`: of the moving parts, from
// SimulatedCamera::SwayAngle. Radiance is linear B, G, R; about 1.0 for a white card in the key light.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "acquisition/simulator/scene/scene.h"
#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

class RayCaster {
 public:
  // Throws Error for a camera whose distortion cannot be inverted at some pixel.
  RayCaster(std::shared_ptr<const Scene> scene, const CameraModel& camera);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;

  const CameraModel& camera() const { return camera_; }
  const Scene& scene() const { return *scene_; }

  // Adds `weight` times the radiance at this pose to `sum` (CV_32FC4: B, G, R, unused).
  void Accumulate(const Rigid3& cam_from_world, float weight, cv::Mat& sum, double sway_angle = 0) const;

  // Does the same for the rows [first, end), for a rolling shutter.
  void AccumulateRows(const Rigid3& cam_from_world, float weight, int first, int end, cv::Mat& sum,
                      double sway_angle = 0) const;

  // Returns the image without motion blur and sensor: CV_32FC3, linear B, G, R.
  cv::Mat Radiance(const Rigid3& cam_from_world, double sway_angle = 0) const;

  // Returns the distance to the first surface along each pixel's ray, metres: CV_32FC1.
  cv::Mat RayLength(const Rigid3& cam_from_world, double sway_angle = 0) const;

  // Returns a mask, CV_8UC1, 255 where the first surface along a pixel's ray moves (Primitive::moves).
  cv::Mat MovingPixels(const Rigid3& cam_from_world, double sway_angle) const;

 private:
  struct Rays;
  struct Tile;
  struct Pose;
  struct Hits;
  void Trace(const Pose& pose, Hits& hits) const;
  void Shade(const Pose& pose, float weight, Hits& hits, cv::Mat& sum) const;
  void SmoothEdges(const Pose& pose, float weight, const Hits& hits, cv::Mat& sum) const;

  std::shared_ptr<const Scene> scene_;
  CameraModel camera_;
  std::unique_ptr<Rays> rays_;
  std::vector<Tile> tiles_;
};

}  // namespace ulf::acquisition
