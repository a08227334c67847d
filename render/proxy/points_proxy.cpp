#include "render/proxy/points_proxy.h"

#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/digest.h"
#include "core/geometry/pinhole.h"
#include "render/proxy/visible_points.h"
#include "render/viewpoints/delaunay.h"

namespace ulf::render {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Triangles extend past the image by this share of its longer side, where points still count. Guessed.
constexpr double kPointsProxyMargin = 0.15;
// Extrapolated points on each side of the image. Guessed.
constexpr int kRimPointsPerSide = 6;
// A point whose inverse depth differs by more than this share from that of every neighbour gets their median.
// Guessed.
constexpr double kWrongBy = 0.3;

struct ImagePoint {
  Vector2d img;
  double inverse_depth;
};

std::vector<ImagePoint> SeenPoints(const std::vector<Vector3d>& points, const CameraModel& camera,
                                   const Rigid3& cam_from_world, double margin_px) {
  std::vector<Vector3d> in_cam;
  std::vector<ImagePoint> projected;
  for (const Vector3d& point : points) {
    const Vector3d p = cam_from_world * point;
    constexpr double kLeastForward = 1e-6;  // cosine to the optical axis: others are far outside any image
    if (!(p.z() > kLeastForward * p.norm())) continue;
    const Vector2d img = PinholeImg(camera, p);
    if (img.x() < -margin_px || img.y() < -margin_px || img.x() > camera.width + margin_px ||
        img.y() > camera.height + margin_px)
      continue;
    in_cam.push_back(p);
    projected.push_back({img, 1 / p.z()});
  }
  const double view_sr =
      (camera.width + 2 * margin_px) * (camera.height + 2 * margin_px) / camera.fx / camera.fy;
  std::vector<ImagePoint> seen;
  for (const std::size_t i : VisiblePoints(in_cam, view_sr)) seen.push_back(projected[i]);
  return seen;
}

// Returns the mean of all points, weighted by one over the fourth power of the distance: smooth, and near the
// image close to the points at its edge.
double Extrapolated(const std::vector<ImagePoint>& seen, const Vector2d& img) {
  double sum = 0, weights = 0;
  for (const ImagePoint& point : seen) {
    const double weight = 1 / std::pow((point.img - img).squaredNorm() + 1, 2);
    sum += weight * point.inverse_depth;
    weights += weight;
  }
  return sum / weights;
}

std::vector<ImagePoint> RimPoints(const std::vector<ImagePoint>& seen, const CameraModel& camera,
                                  double margin_px, int per_side) {
  // The rim lies outside of every point that is seen, so that the triangles contain all of them.
  constexpr double kOutside = 1.01;
  const Vector2d from{-kOutside * margin_px, -kOutside * margin_px};
  const Vector2d size{camera.width - 2 * from.x(), camera.height - 2 * from.y()};
  std::vector<ImagePoint> rim;
  for (int i = 0; i < per_side; ++i) {
    const double share = static_cast<double>(i) / per_side;
    for (const Vector2d& at :
         {Vector2d{share, 0}, Vector2d{1, share}, Vector2d{1 - share, 1}, Vector2d{0, 1 - share}}) {
      const Vector2d img = from + at.cwiseProduct(size);
      rim.push_back({img, Extrapolated(seen, img)});
    }
  }
  return rim;
}

// A point that agrees with none of its neighbours is wrong and gets their median.
void CorrectWrongPoints(const std::vector<Triangle>& triangles, double wrong_by,
                        std::vector<ImagePoint>& points) {
  std::vector<std::vector<double>> around(points.size());
  for (const Triangle& triangle : triangles)
    for (std::size_t corner = 0; corner < 3; ++corner)
      around[At(triangle[corner])].push_back(points[At(triangle[(corner + 1) % 3])].inverse_depth);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double own = points[i].inverse_depth;
    const auto differs = [&](double other) { return std::abs(own / other - 1) > wrong_by; };
    if (around[i].size() > 2 && std::ranges::all_of(around[i], differs))
      points[i].inverse_depth = Median(around[i]);
  }
}

}  // namespace

PointsProxy::PointsProxy(const Subject& subject, const std::vector<ScenePoint>& points) : subject_(subject) {
  for (const ScenePoint& point : points)
    if (point.position_in_world.allFinite()) points_.push_back(point.position_in_world);
  if (points_.size() < kFewest)
    throw Error("{}: the light field has {} tracked points, too few; use another proxy (plane, mesh)",
                Parameter("proxy") + " points", points_.size());
}

std::uint64_t PointsProxy::Fingerprint() const {
  return FastChecksumOf({reinterpret_cast<const char*>(points_.data()), points_.size() * sizeof(Vector3d)},
                        Proxy::Fingerprint());
}

std::shared_ptr<const TriangleMesh> PointsProxy::Triangles(const CameraModel& camera,
                                                           const Rigid3& cam_from_world) const {
  const MutexLock lock(mutex_);
  if (last_cam_from_world_ == cam_from_world.Matrix() && last_camera_ == camera) return last_;
  last_camera_ = camera;
  last_cam_from_world_ = cam_from_world.Matrix();
  last_.reset();
  const double margin_px = kPointsProxyMargin * std::max(camera.width, camera.height);
  std::vector<ImagePoint> points = SeenPoints(points_, camera, cam_from_world, margin_px);
  if (points.size() < kFewest) return nullptr;
  const std::vector<ImagePoint> rim = RimPoints(points, camera, margin_px, kRimPointsPerSide);
  points.insert(points.end(), rim.begin(), rim.end());
  std::vector<Vector2d> img;
  for (const ImagePoint& point : points) img.push_back(point.img);
  const std::vector<Triangle> triangles = PlanarDelaunay(img);
  CorrectWrongPoints(triangles, kWrongBy, points);

  auto mesh = std::make_shared<TriangleMesh>();
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  for (const ImagePoint& point : points)
    mesh->vertices.push_back(
        (world_from_cam * (PinholeRay(camera, point.img) / point.inverse_depth)).cast<float>());
  for (const Triangle& triangle : triangles)
    mesh->triangles.push_back({static_cast<std::uint32_t>(triangle[0]),
                               static_cast<std::uint32_t>(triangle[1]),
                               static_cast<std::uint32_t>(triangle[2])});
  last_ = std::move(mesh);
  return last_;
}

}  // namespace ulf::render
