// A photograph for stereo: grey, undistorted, at the working size.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct StereoView {
  CameraModel camera;  // without distortion
  Rigid3 cam_from_world;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  cv::Mat grey;   // CV_32F, display-encoded, 0 to 255
  cv::Mat valid;  // CV_8U, 0 where the photograph is masked; empty: no mask

  // Returns the image point; none for a point behind the camera or outside the image.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_world) const;
  // Returns the ray through a pixel's centre in the world frame, from the camera's centre to depth 1.
  Eigen::Vector3d RayInWorld(int x, int y) const;
};

// Returns the view at half the size.
StereoView HalfSize(const StereoView& view);

// Makes the view of a photograph, with a longer side of `size_px`, or the photograph's if that is smaller.
StereoView MakeStereoView(const SceneView& view, int size_px);

// Does the same for pictures of a running capture, 8-bit sRGB B G R: it reduces them first, and caches the
// undistortion map of one camera, because views come from one camera for minutes. One thread uses it.
class StereoViewMaker {
 public:
  explicit StereoViewMaker(int size_px) : size_px_(size_px) {}
  StereoView Make(const cv::Mat& srgb8, const CameraModel& camera, const Rigid3& cam_from_world);

 private:
  int size_px_;
  std::optional<CameraModel> camera_;  // of `undistortion_`
  cv::Mat undistortion_;               // for cv::remap
};

}  // namespace ulf::render
