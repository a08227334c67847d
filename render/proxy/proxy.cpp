#include "render/proxy/proxy.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/geometry/digest.h"
#include "core/geometry/pinhole.h"
#include "render/proxy/depth_raster.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::render {

using Eigen::Vector3d;

double PlaneInCamera::DepthOf(const Vector3d& ray_with_unit_z) const {
  const double slope = normal.dot(ray_with_unit_z);
  if (slope * far_depth <= offset) return far_depth;  // parallel to the plane or away from it
  return offset / slope;
}

void FillWithPlane(const PlaneInCamera& plane, const CameraModel& camera, cv::Mat& depth) {
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (float& at = depth.at<float>(y, x); !(at > 0))
        at = static_cast<float>(plane.DepthOf(PinholeRay(camera, x, y)));
}

PlaneInCamera PlaneThroughSubject(const Subject& subject, const Rigid3& cam_from_world) {
  const Vector3d center_in_cam = cam_from_world * subject.center_in_world;
  const double distance = center_in_cam.norm();
  PlaneInCamera plane;
  if (!IsAtCenter(subject, cam_from_world.OriginInSource())) {
    plane.normal = center_in_cam / distance;
    plane.offset = distance;
  } else {
    plane.offset = std::max(subject.radius, 1e-6);  // the far side of the sphere
  }
  plane.far_depth = kFarOverDistance * plane.offset;
  return plane;
}

std::uint64_t Proxy::Fingerprint() const { return Digest().Value(); }

cv::Mat Proxy::Depth(const CameraModel& camera, const Rigid3& cam_from_world) const {
  const PlaneInCamera plane = Background(cam_from_world);
  const auto triangles = Triangles(camera, cam_from_world);
  cv::Mat depth = triangles ? DrawInverseDepth(*triangles, camera, cam_from_world)
                            : cv::Mat::zeros(camera.height, camera.width, CV_32F);
  FillHoles(depth);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (float& at = depth.at<float>(y, x); at > 0) at = 1 / at;
  FillWithPlane(plane, camera, depth);
  return depth;
}

std::string PlaneProxy::Name() const {
  if (!plane_) return distance_share_ == 1 ? "plane" : fmt::format("plane:{:.4g}", distance_share_);
  const Eigen::Vector3d& normal = plane_->normal;
  return fmt::format("plane:{:.4g},{:.4g},{:.4g},{:.4g}", normal.x(), normal.y(), normal.z(), plane_->offset);
}

std::uint64_t PlaneProxy::Fingerprint() const {
  Digest digest;
  if (distance_share_ != 1) digest.Add(distance_share_);
  if (!plane_) return digest.Value();
  for (const double value : plane_->normal) digest.Add(value);
  digest.Add(plane_->offset);
  return digest.Value();
}

std::uint64_t MeshProxy::Fingerprint() const {
  const auto with = [](const auto& values, std::uint64_t seed) {
    return FastChecksumOf({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])},
                          seed);
  };
  return with(mesh_->triangles, with(mesh_->vertices, Proxy::Fingerprint()));
}

PlaneInCamera PlaneProxy::Background(const Rigid3& cam_from_world) const {
  PlaneInCamera facing = PlaneThroughSubject(subject_, cam_from_world);
  facing.offset *= distance_share_;
  if (!plane_) return facing;
  // A camera in the plane sees it edge-on, so the plane is moved by this share of the subject's distance.
  constexpr double kLeastOffset = 1e-6;
  PlaneInCamera plane{.normal = cam_from_world.rotation * plane_->normal, .far_depth = facing.far_depth};
  plane.offset = plane_->offset + plane.normal.dot(cam_from_world.translation);
  if (plane.offset < 0) plane = {-plane.normal, -plane.offset, plane.far_depth};
  plane.offset = std::max(plane.offset, kLeastOffset * facing.offset);
  return plane;
}

}  // namespace ulf::render
