// The geometry that photographs are projected onto. One question: how deep is each pixel, for any camera.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "acquisition/camera_model.h"
#include "acquisition/light_field.h"
#include "acquisition/rigid3.h"

namespace ulf {

// Points x of the camera frame with normal . x = offset; the normal points away from the camera, offset > 0.
struct PlaneInCamera {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 1;
  double far_depth = 1e6;  // depth of pixels whose rays do not meet the plane, and the most there is

  // Depth along the optical axis of the ray (x, y, 1).
  double DepthOf(const Eigen::Vector3d& ray_with_unit_z) const;
};

class Proxy {
 public:
  virtual ~Proxy() = default;
  virtual std::string Name() const = 0;
  // CV_32F depth along the optical axis, positive everywhere, at the pixel centres of an undistorted camera.
  virtual cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) const = 0;
  // Where the proxy is one plane for this camera, the plane: the fast path evaluates it by itself.
  virtual std::optional<PlaneInCamera> AsPlane(const Rigid3& cam_from_world) const;
};

// The plane through the subject's centre that faces the virtual camera.
class PlaneProxy : public Proxy {
 public:
  explicit PlaneProxy(const Subject& subject) : subject_(subject) {}
  std::string Name() const override { return "plane"; }
  cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) const override;
  std::optional<PlaneInCamera> AsPlane(const Rigid3& cam_from_world) const override;

 private:
  Subject subject_;
};

}  // namespace ulf
