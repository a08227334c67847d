// The proxy is the geometry onto which photographs are projected: triangles, or a plane. It gives the depth
// of each pixel for any camera. Holes between the triangles of a picture are filled from the depths around
// them; a picture that shows no triangle shows the plane.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

// The plane normal . x = offset > 0 of points x in the camera frame; the normal points away from the camera.
struct PlaneInCamera {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 1;       // world units
  double far_depth = 1e6;  // the largest depth, which pixels whose rays do not meet the plane have as well

  // Returns the depth along the optical axis at which the ray (x, y, 1) meets the plane.
  double DepthOf(const Eigen::Vector3d& ray_with_unit_z) const;
};

// Replaces depths of 0 (CV_32F, of the camera's size) by the plane's.
void FillWithPlane(const PlaneInCamera& plane, const CameraModel& camera, cv::Mat& depth);

// Returns the plane through the subject's centre that faces the camera. Its far_depth is kFarOverDistance
// times the distance to the subject.
PlaneInCamera PlaneThroughSubject(const Subject& subject, const Rigid3& cam_from_world);
inline constexpr double kFarOverDistance = 1000;

class Proxy {
 public:
  virtual ~Proxy() = default;
  virtual std::string Name() const = 0;
  // Returns a number that tells proxies of one name apart; the same for all that the subject alone defines.
  virtual std::uint64_t Fingerprint() const;
  // Returns the plane of pictures that show no triangle.
  virtual PlaneInCamera Background(const Rigid3& cam_from_world) const = 0;
  // Returns the triangles that this camera may see, in the world frame, visible from both sides; null if
  // there are none. The same pointer is the same mesh.
  virtual std::shared_ptr<const TriangleMesh> Triangles(const CameraModel& /*camera*/,
                                                        const Rigid3& /*cam_from_world*/) const {
    return nullptr;
  }
  // Returns the triangles that hide points from the recorded views; null if nothing is hidden.
  virtual std::shared_ptr<const TriangleMesh> Occluder() const { return nullptr; }
  virtual bool HasDepthMaps() const { return false; }
  // Returns the depth map of a recorded view; null if HasDepthMaps() is false.
  virtual std::shared_ptr<const LazyDepthMap> DepthMapOf(int /*view_id*/, const CameraModel& /*camera*/,
                                                         const Rigid3& /*cam_from_world*/) const {
    return nullptr;
  }

  // Returns CV_32F depth along the optical axis, positive, at the pixel centres of an undistorted camera.
  cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) const;
};

// A plane that faces the virtual camera, through the subject's centre or at a share of its distance, or a
// plane that is fixed in the world.
class PlaneProxy : public Proxy {
 public:
  struct InWorld {
    Eigen::Vector3d normal;  // unit
    double offset = 0;       // normal . x of its points
  };
  explicit PlaneProxy(const Subject& subject, const std::optional<InWorld>& plane = std::nullopt)
      : subject_(subject), plane_(plane) {}
  // A `distance_share` below 1 is nearer than the subject's centre, above 1 farther.
  PlaneProxy(const Subject& subject, double distance_share)
      : subject_(subject), distance_share_(distance_share) {}
  std::string Name() const override;
  std::uint64_t Fingerprint() const override;
  PlaneInCamera Background(const Rigid3& cam_from_world) const override;

 private:
  Subject subject_;
  std::optional<InWorld> plane_;
  double distance_share_ = 1;  // for a plane that faces the camera
};

// A mesh in the world; pictures that show nothing of it use the plane through the subject.
class MeshProxy : public Proxy {
 public:
  MeshProxy(const Subject& subject, std::shared_ptr<const TriangleMesh> mesh, std::string name = "mesh")
      : subject_(subject), mesh_(std::move(mesh)), name_(std::move(name)) {}
  std::string Name() const override { return name_; }
  std::uint64_t Fingerprint() const override;
  PlaneInCamera Background(const Rigid3& cam_from_world) const override {
    return PlaneThroughSubject(subject_, cam_from_world);
  }
  std::shared_ptr<const TriangleMesh> Triangles(const CameraModel&, const Rigid3&) const override {
    return mesh_;
  }
  std::shared_ptr<const TriangleMesh> Occluder() const override { return mesh_; }

 private:
  Subject subject_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::string name_;
};

}  // namespace ulf::render
