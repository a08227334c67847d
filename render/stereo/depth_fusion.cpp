#include "render/stereo/depth_fusion.h"

#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/parallel_for.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

struct Reading {
  int x, y;
  double point_depth;  // of the point
  double map_depth;    // 0: none
};

// Reads a view's map at the pixel onto which a point projects.
std::optional<Reading> ReadMap(const ViewDepth& view, const Vector3d& point_in_world) {
  const Vector3d in_cam = view.view.cam_from_world * point_in_world;
  if (!(in_cam.z() > 0)) return std::nullopt;
  const CameraModel& camera = view.view.camera;
  const int x = static_cast<int>(std::floor(camera.fx * in_cam.x() / in_cam.z() + camera.cx));
  const int y = static_cast<int>(std::floor(camera.fy * in_cam.y() / in_cam.z() + camera.cy));
  if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return std::nullopt;
  return Reading{x, y, in_cam.z(), view.depth.at<float>(y, x)};
}

bool Agree(const ViewDepth& view, double depth, double other_depth, double tolerance_planes) {
  return other_depth > 0 && std::abs(1 / depth - 1 / other_depth) <= tolerance_planes * view.plane_step;
}

cv::Mat Agreed(const std::vector<ViewDepth>& views, std::size_t index, const std::vector<int>& others,
               const FusionOptions& options) {
  const ViewDepth& own = views[index];
  cv::Mat kept = cv::Mat::zeros(own.depth.size(), CV_32F);
  const Vector3d axis = own.view.cam_from_world.DirectionInSource(Vector3d::UnitZ());
  for (int y = 0; y < kept.rows; ++y)
    for (int x = 0; x < kept.cols; ++x) {
      const double depth = own.depth.at<float>(y, x);
      if (!(depth > 0)) continue;
      const Vector3d point = own.view.center_in_world + depth * own.view.RayInWorld(x, y);
      double sum = 1 / depth;
      int agreeing = 0, seen_through = 0;
      for (const int other : others) {
        const ViewDepth& view = views[At(other)];
        const auto reading = ReadMap(view, point);
        if (!reading || !(reading->map_depth > 0)) continue;
        if (Agree(view, reading->point_depth, reading->map_depth, options.tolerance_planes)) {
          const Vector3d other_point =
              view.view.center_in_world + reading->map_depth * view.view.RayInWorld(reading->x, reading->y);
          // The depth is along the own axis, because the other map's pixel is not exactly the same place.
          const double own_depth = axis.dot(other_point - own.view.center_in_world);
          if (own_depth <= 0) continue;
          sum += 1 / own_depth;
          ++agreeing;
        } else if (reading->map_depth > reading->point_depth) {
          ++seen_through;
        }
      }
      if (agreeing >= options.agreeing_views && agreeing > seen_through)
        kept.at<float>(y, x) = static_cast<float>((agreeing + 1) / sum);
    }
  return kept;
}

// Marks the pixels around one that show the same surface.
void Mark(const ViewDepth& view, int x, int y, double depth, const FusionOptions& options, cv::Mat& taken) {
  const int radius = options.spacing_px;
  for (int v = std::max(0, y - radius); v <= std::min(taken.rows - 1, y + radius); ++v)
    for (int u = std::max(0, x - radius); u <= std::min(taken.cols - 1, x + radius); ++u)
      if (Agree(view, depth, view.depth.at<float>(v, u), options.tolerance_planes * (1 + radius)))
        taken.at<std::uint8_t>(v, u) = 1;
}

}  // namespace

void KeepConsistentDepths(std::vector<ViewDepth>& views, const std::vector<std::vector<int>>& others,
                          const FusionOptions& options) {
  std::vector<cv::Mat> kept(views.size());
  ParallelFor(
      views.size(), [&](std::size_t i) { kept[i] = Agreed(views, i, others[i], options); },
      options.in_this_thread ? 1 : 0);
  for (std::size_t i = 0; i < views.size(); ++i) views[i].depth = kept[i];
}

std::vector<FusedPoint> FusePoints(const std::vector<ViewDepth>& views,
                                   const std::vector<std::vector<int>>& others,
                                   const FusionOptions& options) {
  std::vector<cv::Mat> taken;
  for (const ViewDepth& view : views) taken.push_back(cv::Mat::zeros(view.depth.size(), CV_8U));
  std::vector<FusedPoint> points;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewDepth& own = views[i];
    for (int y = 0; y < own.depth.rows; ++y)
      for (int x = 0; x < own.depth.cols; ++x) {
        const double depth = own.depth.at<float>(y, x);
        if (!(depth > 0) || taken[i].at<std::uint8_t>(y, x)) continue;
        FusedPoint point;
        point.position_in_world = own.view.center_in_world + depth * own.view.RayInWorld(x, y);
        point.spread = depth * depth * own.plane_step;
        point.pixel = depth / own.view.camera.MeanFocalPx();
        point.seen_by.push_back(static_cast<std::uint16_t>(i));
        Mark(own, x, y, depth, options, taken[i]);
        for (const int other : others[i]) {
          const std::size_t at = At(other);
          const auto reading = ReadMap(views[at], point.position_in_world);
          if (!reading ||
              !Agree(views[at], reading->point_depth, reading->map_depth, options.tolerance_planes))
            continue;
          point.seen_by.push_back(static_cast<std::uint16_t>(other));
          Mark(views[at], reading->x, reading->y, reading->point_depth, options, taken[at]);
        }
        points.push_back(std::move(point));
      }
  }
  return points;
}

}  // namespace ulf::render
