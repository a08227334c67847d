#include "render/proxy/shadow_map.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "render/proxy/depth_raster.h"

namespace ulf::render {
namespace {

// Share of the inverse depth. If it changes by more from texel to texel there is an edge, and the change to
// the other side does not count; below that the surface is rough, and the larger change counts. Measured
// (docs/rendering.md, Quality: the smaller change cost 0.1 to 0.7 dB).
constexpr float kShadowMapEdge = 0.1f;
// Tangent of the widest angle between a ray of the map and its axis: one map cannot hold more. Guessed.
constexpr double kMostSlope = 3;

// Returns the change of inverse depth to the texels on both sides: the larger one on a surface, which may be
// rough; at an edge, where a change exceeds `edge` of the inverse depth, the smaller one, which is the
// surface's.
float Slope(float before, float here, float behind, float edge) {
  const float back = before > 0 ? std::abs(here - before) : -1,
              on = behind > 0 ? std::abs(behind - here) : -1;
  if (back < 0 || on < 0) return std::max({back, on, 0.0f});
  return std::max(back, on) < edge * here ? std::max(back, on) : std::min(back, on);
}

}  // namespace

// Computes it from the rays through the edge of the view's image.
CameraModel ShadowMapCamera(const CameraModel& view) {
  constexpr int kSteps = 16;         // on each side of the image
  constexpr double kSideways = 1e9;  // of rays that do not go forwards; limited by kMostSlope
  Eigen::Vector2d low(0, 0), high(0, 0);
  const auto meet = [&](double x, double y) {
    const auto ray = view.RayFromImg({x, y});
    if (!ray) return;
    const Eigen::Vector2d slope = ray->z() > 0 ? Eigen::Vector2d(ray->head<2>() / ray->z())
                                               : Eigen::Vector2d(ray->head<2>() * kSideways);
    low = low.cwiseMin(slope.cwiseMax(-kMostSlope));
    high = high.cwiseMax(slope.cwiseMin(kMostSlope));
  };
  for (int i = 0; i <= kSteps; ++i) {
    const double x = view.width * i / double{kSteps}, y = view.height * i / double{kSteps};
    meet(x, 0), meet(x, view.height), meet(0, y), meet(view.width, y);
  }
  CameraModel camera = CameraModel::Pinhole(kShadowMapPx, kShadowMapPx, 1);
  camera.fx = camera.width / (high.x() - low.x());
  camera.fy = camera.height / (high.y() - low.y());
  camera.cx = -camera.fx * low.x();
  camera.cy = -camera.fy * low.y();
  return camera;
}

double ShadowMap::Visibility(const Eigen::Vector3d& point_in_view) const {
  if (!(point_in_view.z() > 0)) return 1;
  const double inverse = 1 / point_in_view.z();
  const double x = camera.fx * point_in_view.x() * inverse + camera.cx;
  const double y = camera.fy * point_in_view.y() * inverse + camera.cy;
  if (!(x >= 0 && y >= 0 && x <= camera.width && y <= camera.height)) return 1;
  const int left = static_cast<int>(std::floor(x - 0.5)), top = static_cast<int>(std::floor(y - 0.5));
  const double right_share = x - 0.5 - left, below_share = y - 0.5 - top;
  const auto seen = [&](int column, int row) {
    return inverse >= least_inverse_depth.at<float>(std::clamp(row, 0, camera.height - 1),
                                                    std::clamp(column, 0, camera.width - 1))
               ? 1.0
               : 0.0;
  };
  return (1 - below_share) * ((1 - right_share) * seen(left, top) + right_share * seen(left + 1, top)) +
         below_share * ((1 - right_share) * seen(left, top + 1) + right_share * seen(left + 1, top + 1));
}

ShadowMap MakeShadowMap(const TriangleMesh& occluder, const CameraModel& view_camera,
                        const Rigid3& view_from_world, double tolerance) {
  ShadowMap map{.camera = ShadowMapCamera(view_camera), .least_inverse_depth = {}};
  const cv::Mat inverse = DrawInverseDepth(occluder, map.camera, view_from_world);
  cv::Mat least(inverse.size(), CV_32F);
  for (int y = 0; y < inverse.rows; ++y)
    for (int x = 0; x < inverse.cols; ++x) {
      const auto at = [&](int column, int row) {
        return column < 0 || row < 0 || column >= inverse.cols || row >= inverse.rows
                   ? 0.0f
                   : inverse.at<float>(row, column);
      };
      const float here = at(x, y);
      const float slope = Slope(at(x - 1, y), here, at(x + 1, y), kShadowMapEdge) +
                          Slope(at(x, y - 1), here, at(x, y + 1), kShadowMapEdge);
      // A point is compared with texels up to one away, and their depths come from up to one texel farther.
      least.at<float>(y, x) =
          here > 0 ? std::max(0.0f, static_cast<float>((1 - tolerance) * here) - 2 * slope) : 0.0f;
    }
  // A photograph mixes the colours of both sides within a texel of an edge: hide that texel, too.
  cv::dilate(least, map.least_inverse_depth, cv::Mat::ones(3, 3, CV_8U));
  return map;
}

}  // namespace ulf::render
