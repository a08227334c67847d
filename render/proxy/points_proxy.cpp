#include "render/proxy/points_proxy.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "render/fields/planar_delaunay.h"
#include "render/proxy/visible_points.h"
#include "render/scene/fingerprint.h"

namespace ulf::render {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kMargin = 0.15;  // beyond the frame, of its longer side
constexpr int kRimPointsPerSide = 6;
constexpr double kWrongBy = 0.3;  // inverse depth, against all neighbours

struct ImagePoint {
  Vector2d img;
  double inverse_depth;
};

template <typename T>
T MedianOf(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<ImagePoint> SeenPoints(const std::vector<Vector3d>& points, const CameraModel& camera,
                                   const Rigid3& cam_from_world, double margin_px) {
  std::vector<Vector3d> in_cam;
  std::vector<ImagePoint> projected;
  for (const Vector3d& point : points) {
    const Vector3d p = cam_from_world * point;
    if (!(p.z() > 1e-6 * p.norm())) continue;
    const Vector2d img{camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy};
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

// All points by their nearness to the fourth power: near the frame those at its rim decide, and nothing
// jumps.
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
                                  double margin_px) {
  const Vector2d from{-1.01 * margin_px, -1.01 * margin_px};
  const Vector2d size{camera.width - 2 * from.x(), camera.height - 2 * from.y()};
  std::vector<ImagePoint> rim;
  for (int i = 0; i < kRimPointsPerSide; ++i) {
    const double share = static_cast<double>(i) / kRimPointsPerSide;
    for (const Vector2d& at :
         {Vector2d{share, 0}, Vector2d{1, share}, Vector2d{1 - share, 1}, Vector2d{0, 1 - share}}) {
      const Vector2d img = from + at.cwiseProduct(size);
      rim.push_back({img, Extrapolated(seen, img)});
    }
  }
  return rim;
}

// One point that agrees with none of its neighbours is taken to be wrong and gets their median.
void MendWrongPoints(const std::vector<Triangle>& triangles, std::vector<ImagePoint>& points) {
  std::vector<std::vector<double>> around(points.size());
  for (const Triangle& triangle : triangles)
    for (std::size_t corner = 0; corner < 3; ++corner)
      around[static_cast<std::size_t>(triangle[corner])].push_back(
          points[static_cast<std::size_t>(triangle[(corner + 1) % 3])].inverse_depth);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double own = points[i].inverse_depth;
    const auto differs = [own](double other) { return std::abs(own / other - 1) > kWrongBy; };
    if (around[i].size() > 2 && std::all_of(around[i].begin(), around[i].end(), differs))
      points[i].inverse_depth = MedianOf(around[i]);
  }
}

}  // namespace

PointsProxy::PointsProxy(const Subject& subject, const std::vector<ScenePoint>& points) : subject_(subject) {
  for (const ScenePoint& point : points)
    if (point.position_in_world.allFinite()) points_.push_back(point.position_in_world);
  if (points_.size() < kFewest)
    throw Error("--proxy points: the light field has {} tracked points; take another proxy (plane, mesh)",
                points_.size());
}

void PointsProxy::AddTo(Fingerprint& fingerprint) const { fingerprint.AddAll(points_); }

std::shared_ptr<const TriangleMesh> PointsProxy::Triangles(const CameraModel& camera,
                                                           const Rigid3& cam_from_world) const {
  const MutexLock lock(mutex_);
  if (last_cam_from_world_ == cam_from_world.Matrix() && last_camera_ == camera) return last_;
  last_camera_ = camera;
  last_cam_from_world_ = cam_from_world.Matrix();
  last_.reset();
  const double margin_px = kMargin * std::max(camera.width, camera.height);
  std::vector<ImagePoint> points = SeenPoints(points_, camera, cam_from_world, margin_px);
  if (points.size() < kFewest) return nullptr;
  const std::vector<ImagePoint> rim = RimPoints(points, camera, margin_px);
  points.insert(points.end(), rim.begin(), rim.end());
  std::vector<Vector2d> img;
  for (const ImagePoint& point : points) img.push_back(point.img);
  const std::vector<Triangle> triangles = PlanarDelaunay(img);
  MendWrongPoints(triangles, points);

  auto mesh = std::make_shared<TriangleMesh>();
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  for (const ImagePoint& point : points) {
    const Vector3d ray{(point.img.x() - camera.cx) / camera.fx, (point.img.y() - camera.cy) / camera.fy, 1};
    mesh->vertices.push_back((world_from_cam * (ray / point.inverse_depth)).cast<float>());
  }
  for (const Triangle& triangle : triangles)
    mesh->triangles.push_back({static_cast<std::uint32_t>(triangle[0]),
                               static_cast<std::uint32_t>(triangle[1]),
                               static_cast<std::uint32_t>(triangle[2])});
  last_ = std::move(mesh);
  return last_;
}

}  // namespace ulf::render
