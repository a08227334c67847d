#include "render/proxy/shadow_map.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "render/proxy/depth_raster.h"

namespace ulf::render {
namespace {

// Of the changes to both sides the larger, as long as both are a surface's, which may be rough; at its edge,
// where one is more than kEdge of the nearness, that of the side that belongs to it.
float Slope(float before, float here, float behind) {
  constexpr float kEdge = 0.1f;
  const float back = before > 0 ? std::abs(here - before) : -1,
              on = behind > 0 ? std::abs(behind - here) : -1;
  if (back < 0 || on < 0) return std::max({back, on, 0.0f});
  return std::max(back, on) < kEdge * here ? std::max(back, on) : std::min(back, on);
}

}  // namespace

// Rays through its rim, up to a slope that one map can hold.
CameraModel ShadowMapCamera(const CameraModel& view) {
  constexpr double kMostSlope = 3;
  constexpr int kSteps = 16;
  Eigen::Vector2d low(0, 0), high(0, 0);
  const auto meet = [&](double x, double y) {
    const auto ray = view.RayFromImg({x, y});
    if (!ray) return;
    const Eigen::Vector2d slope =
        ray->z() > 0 ? Eigen::Vector2d(ray->head<2>() / ray->z()) : Eigen::Vector2d(ray->head<2>() * 1e9);
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
                        const Rigid3& view_from_world) {
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
      const float slope = Slope(at(x - 1, y), here, at(x + 1, y)) + Slope(at(x, y - 1), here, at(x, y + 1));
      // A point is compared with texels up to one away, and what is there came from up to one farther.
      least.at<float>(y, x) =
          here > 0 ? std::max(0.0f, static_cast<float>((1 - kShadowMapTolerance) * here) - 2 * slope) : 0.0f;
    }
  // The colours of an edge spill over it by a texel, and so does what it hides.
  cv::dilate(least, map.least_inverse_depth, cv::Mat::ones(3, 3, CV_8U));
  return map;
}

}  // namespace ulf::render
