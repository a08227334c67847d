// A mesh of a subject that was seen from one side.
#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"
#include "render/stereo/depth_fusion.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/proxy_builder.h"
#include "render/stereo/surface_cut.h"
#include "render/stereo/view_selection.h"
#include "tests/measure/curve.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/stability/render_draw.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

// A ball or a box about the origin.
class Solid {
 public:
  Solid(unsigned seed, SceneDraw& draw)
      : is_ball_(seed % 2 == 1),
        half_(draw.Uniform(0.45, 0.65), draw.Uniform(0.45, 0.65), draw.Uniform(0.45, 0.65)),
        box_from_world_(draw.Rotation()) {}

  double DistanceTo(const Vector3d& point) const {
    if (is_ball_) return std::abs(point.norm() - 1);
    const Vector3d beyond = (box_from_world_ * point).cwiseAbs() - half_;
    return std::abs(beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff()));
  }

  // Along a ray, in its length; none past the solid.
  std::optional<double> Hit(const Vector3d& origin, const Vector3d& ray) const {
    if (is_ball_) {
      const double half_b = origin.dot(ray) / ray.squaredNorm();
      const double inside = half_b * half_b - (origin.squaredNorm() - 1) / ray.squaredNorm();
      if (inside < 0) return std::nullopt;
      return -half_b - std::sqrt(inside);
    }
    const Vector3d from = box_from_world_ * origin, along = box_from_world_ * ray;
    const Vector3d first = (-half_ - from).cwiseQuotient(along), second = (half_ - from).cwiseQuotient(along);
    const double enters = first.cwiseMin(second).maxCoeff(), leaves = first.cwiseMax(second).minCoeff();
    if (enters > leaves) return std::nullopt;
    return enters;
  }

 private:
  bool is_ball_;
  Vector3d half_;
  Quaterniond box_from_world_;
};

constexpr double kSolidDistance = 4, kNearest = 2.5, kFarthest = 5.5;

StereoView ViewOfSolid(const Vector3d& direction) {
  StereoView view;
  view.camera = CameraModel::Pinhole(120, 120, 170);
  view.center_in_world = kSolidDistance * direction;
  view.cam_from_world = LookAt(view.center_in_world, Vector3d::Zero(), direction.unitOrthogonal());
  return view;
}

// The depth map that a sweep against the neighbours would find: off by a quarter of a pixel of the neighbour
// that moves the most.
ViewDepth DepthOf(const Solid& solid, const StereoView& view,
                  const std::vector<const StereoView*>& neighbours, SceneDraw& draw) {
  constexpr double kNoisePx = 0.25;
  const InverseDepthRange range = PixelSpacedRange(view, neighbours, kNearest, kFarthest);
  double widest = 0;
  for (const StereoView* neighbour : neighbours)
    widest = std::max(widest, (neighbour->center_in_world - view.center_in_world).norm());
  ViewDepth map{view, cv::Mat::zeros(view.camera.height, view.camera.width, CV_32F),
                (range.most - range.least) / (range.planes - 1)};
  for (int y = 0; y < map.depth.rows; ++y)
    for (int x = 0; x < map.depth.cols; ++x)
      if (const auto depth = solid.Hit(view.center_in_world, view.RayInWorld(x, y))) {
        const double inverse = 1 / *depth + kNoisePx * draw.Normal() / (view.camera.fx * widest);
        map.depth.at<float>(y, x) = static_cast<float>(1 / std::clamp(inverse, range.least, range.most));
      }
  return map;
}

// The distance from the solid that nineteen twentieths of the mesh's area keep.
double MostlyWithin(const TriangleMesh& mesh, const Solid& solid) {
  std::vector<std::pair<double, double>> area_at;
  double area = 0;
  for (const auto& of : mesh.triangles) {
    const Vector3d a = mesh.vertices[of[0]].cast<double>(), b = mesh.vertices[of[1]].cast<double>(),
                   c = mesh.vertices[of[2]].cast<double>();
    area_at.emplace_back(solid.DistanceTo((a + b + c) / 3), 0.5 * (b - a).cross(c - a).norm());
    area += area_at.back().second;
  }
  std::sort(area_at.begin(), area_at.end());
  double sum = 0;
  for (const auto& [distance, size] : area_at)
    if ((sum += size) >= 0.95 * area) return distance;
  return area_at.back().first;
}

CURVE(proxy_missing_sides,
      {.stage = "Proxy",
       .title = "A mesh of what was seen from ever fewer sides",
       .about =
           R"(40 views of a ball or a box within a cone around one side of it; depth maps a quarter of a
  pixel off go into `ulf proxy`'s fusion and surface. Right: 95 % of the mesh's area lie within 5 % of the
  subject's radius of its surface. No mesh, or that a pixel is worth too much depth, says so.)",
       .driven = {Log("360 deg over the opening of the cone that holds the views"),
                  {1, 1.33, 2, 3, 6, 12, 24, 45, 90, 180, 360},
                  2,
                  360},
       .error = Log("distance of 95 % of the area [radii]"),
       .trial =
           [](double fewer, unsigned seed) {
             constexpr double kRight = 0.05;
             SceneDraw draw(seed);
             const Solid solid(seed, draw);
             const Subject subject{Vector3d::Zero(), 1};
             const Quaterniond turn = draw.Rotation();
             std::vector<StereoView> views;
             for (const Vector3d& direction : CapViewpoints(40, M_PI / fewer, 1))
               views.push_back(ViewOfSolid(turn * direction));
             std::vector<ViewDepth> maps;
             std::vector<Vector3d> centers;
             std::vector<double> pixel_depths;
             for (std::size_t i = 0; i < views.size(); ++i) {
               std::vector<const StereoView*> neighbours;
               for (const int other : NeighboursOf(static_cast<int>(i), views, subject, 8))
                 neighbours.push_back(&views[At(other)]);
               if (neighbours.empty()) continue;
               maps.push_back(DepthOf(solid, views[i], neighbours, draw));
               centers.push_back(views[i].center_in_world);
               pixel_depths.push_back(DepthStepOfPixel(views[i], neighbours, kSolidDistance));
             }
             if (maps.empty() || Median(pixel_depths) > kRoughPixelRadii * subject.radius)
               return Trial{Verdict::kSaidSo, 0};
             std::vector<StereoView> mapped;
             for (const ViewDepth& map : maps) mapped.push_back(map.view);
             std::vector<std::vector<int>> others;
             for (std::size_t i = 0; i < mapped.size(); ++i)
               others.push_back(NeighboursOf(static_cast<int>(i), mapped, subject, 10));
             KeepConsistentDepths(maps, others, {});
             const TriangleMesh mesh = CutSurface(FusePoints(maps, others, {}), centers);
             if (mesh.triangles.empty()) return Trial{Verdict::kSaidSo, 0};
             const double distance = MostlyWithin(mesh, solid);
             return Trial{distance < kRight ? Verdict::kRight : Verdict::kWrong, distance};
           },
       .seeds = 4});

}  // namespace
}  // namespace ulf::test
