// The geometry onto which photographs are projected: triangles, or a plane. A proxy answers one question: how
// deep is each pixel, for any camera. Holes between the triangles of a picture are filled from the depths
// around them; a picture that shows no triangle shows the plane.
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

// Points x of the camera frame with normal . x = offset; the normal points away from the camera, offset > 0.
struct PlaneInCamera {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 1;       // world units
  double far_depth = 1e6;  // the largest depth, and the depth of pixels whose rays do not meet the plane

  // Depth along the optical axis of the ray (x, y, 1).
  double DepthOf(const Eigen::Vector3d& ray_with_unit_z) const;
};

// Replaces depths of 0 by the plane's.
void FillWithPlane(const PlaneInCamera& plane, const CameraModel& camera, cv::Mat& depth);

// The plane through the subject's centre that faces the camera. Its far_depth is kFarOverDistance times the
// distance to the subject.
PlaneInCamera PlaneThroughSubject(const Subject& subject, const Rigid3& cam_from_world);
inline constexpr double kFarOverDistance = 1000;

class Proxy {
 public:
  virtual ~Proxy() = default;
  virtual std::string Name() const = 0;
  // A number that differs between proxies of the same name; the same for all where the subject defines them.
  virtual std::uint64_t Fingerprint() const;
  // The plane of pictures that show no triangle.
  virtual PlaneInCamera Background(const Rigid3& cam_from_world) const = 0;
  // World triangles for this camera, seen from both sides; null: none. The same pointer is the same mesh.
  virtual std::shared_ptr<const TriangleMesh> Triangles(const CameraModel& /*camera*/,
                                                        const Rigid3& /*cam_from_world*/) const {
    return nullptr;
  }
  // The triangles that hide points from the recorded views; null: nothing is hidden.
  virtual std::shared_ptr<const TriangleMesh> Occluder() const { return nullptr; }
  virtual bool HasDepthMaps() const { return false; }
  // The depth map of a recorded view; null where HasDepthMaps() is false.
  virtual std::shared_ptr<const LazyDepthMap> DepthMapOf(int /*view_id*/, const CameraModel& /*camera*/,
                                                         const Rigid3& /*cam_from_world*/) const {
    return nullptr;
  }

  // CV_32F depth along the optical axis, positive everywhere, at the pixel centres of an undistorted camera.
  cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) const;
};

// The plane that faces the virtual camera, through the subject's centre or at a share of its distance; or a
// plane that is fixed in the world.
class PlaneProxy : public Proxy {
 public:
  struct InWorld {
    Eigen::Vector3d normal;  // unit
    double offset = 0;       // normal . x of its points
  };
  explicit PlaneProxy(const Subject& subject, const std::optional<InWorld>& plane = std::nullopt)
      : subject_(subject), plane_(plane) {}
  // `distance_share`: below 1 nearer than the subject's centre, above 1 farther.
  PlaneProxy(const Subject& subject, double distance_share)
      : subject_(subject), distance_share_(distance_share) {}
  std::string Name() const override;
  std::uint64_t Fingerprint() const override;
  PlaneInCamera Background(const Rigid3& cam_from_world) const override;

 private:
  Subject subject_;
  std::optional<InWorld> plane_;
  double distance_share_ = 1;  // of a plane that faces the camera
};

// A mesh in the world; where a picture shows nothing of it, the plane through the subject.
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
