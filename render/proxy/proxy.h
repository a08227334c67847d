// The geometry that photographs are projected onto: triangles, or a plane. One question: how deep is each
// pixel, for any camera. Where triangles leave holes in a picture, these are as deep as what is around them;
// where a picture shows none at all, it shows the plane.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// Points x of the camera frame with normal . x = offset; the normal points away from the camera, offset > 0.
struct PlaneInCamera {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 1;
  double far_depth = 1e6;  // depth of pixels whose rays do not meet the plane, and the most there is

  // Depth along the optical axis of the ray (x, y, 1).
  double DepthOf(const Eigen::Vector3d& ray_with_unit_z) const;
};

// Depths of 0 become the plane's.
void FillWithPlane(const PlaneInCamera& plane, const CameraModel& camera, cv::Mat& depth);

// The plane through the subject's centre that faces the camera.
PlaneInCamera PlaneThroughSubject(const Subject& subject, const Rigid3& cam_from_world);

class Fingerprint;

class Proxy {
 public:
  virtual ~Proxy() = default;
  virtual std::string Name() const = 0;
  // What distinguishes it from others of its name; nothing where the subject says all.
  virtual void AddTo(Fingerprint& fingerprint) const;
  // What pictures show that show no triangle.
  virtual PlaneInCamera Background(const Rigid3& cam_from_world) const = 0;
  // World triangles for this camera, both of their sides; null: none. The same pointer is the same mesh.
  virtual std::shared_ptr<const TriangleMesh> Triangles(const CameraModel& camera,
                                                        const Rigid3& cam_from_world) const;
  // What hides points from the recorded views; null: nothing does.
  virtual std::shared_ptr<const TriangleMesh> Occluder() const;

  // CV_32F depth along the optical axis, positive everywhere, at the pixel centres of an undistorted camera.
  cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) const;
};

// The plane through the subject's centre that faces the virtual camera; or one that stands in the world.
class PlaneProxy : public Proxy {
 public:
  struct InWorld {
    Eigen::Vector3d normal;  // unit
    double offset = 0;       // normal . x of its points
  };
  explicit PlaneProxy(const Subject& subject, const std::optional<InWorld>& plane = std::nullopt)
      : subject_(subject), plane_(plane) {}
  std::string Name() const override;
  void AddTo(Fingerprint& fingerprint) const override;
  PlaneInCamera Background(const Rigid3& cam_from_world) const override;

 private:
  Subject subject_;
  std::optional<InWorld> plane_;
};

// A surface in the world; where nothing of it is in the picture, the plane through the subject.
class MeshProxy : public Proxy {
 public:
  MeshProxy(const Subject& subject, std::shared_ptr<const TriangleMesh> mesh, std::string name = "mesh")
      : subject_(subject), mesh_(std::move(mesh)), name_(std::move(name)) {}
  std::string Name() const override { return name_; }
  void AddTo(Fingerprint& fingerprint) const override;
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
