#include "tracking/refine/view_rows.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// With fewer points the middle row's pose is not certain. Guessed.
constexpr std::size_t kLeastRowPoints = 12;
// The recorded velocity stays: standard deviation, rad/s and world units/s.
constexpr double kHeldSigma = 1e-9;
// Each step reduces the error of a row's time to some percent.
constexpr int kSeenSteps = 4;

struct PointsOfView {
  std::vector<SeenPoint> points;
  std::vector<DepthField::Sample> samples;
};

std::map<int, PointsOfView> PointsOfMovingViews(const LightField& light_field) {
  std::map<int, PointsOfView> by_view;
  for (const ScenePoint& point : light_field.points)
    for (const ViewObservation& seen : point.track) {
      const View* view = light_field.FindView(seen.view_id);
      if (!view || !view->twist) continue;
      const double depth = (view->cam_from_world * point.position_in_world).z();
      if (!(depth > 0)) continue;
      PointsOfView& of_view = by_view[seen.view_id];
      of_view.points.push_back({point.position_in_world, seen.in_img});
      of_view.samples.push_back({seen.in_img, depth});
    }
  return by_view;
}

std::optional<ViewRows> FittedRows(const LightField& light_field, const View& view,
                                   const PointsOfView& seen) {
  if (seen.points.size() < kLeastRowPoints) return std::nullopt;
  const CameraModel& camera = light_field.CameraOf(view);
  const Twist twist = Eigen::Map<const Twist>(view.twist->data());
  const double readout_s = light_field.readout->readout_s;
  const auto found = RefinePoseAndMotion(camera, readout_s, seen.points, view.cam_from_world,
                                         {twist, Twist::Constant(kHeldSigma)});
  if (!found) return std::nullopt;
  return ViewRows{found->cam_from_world, twist, readout_s, DepthField(camera, seen.samples)};
}

// Returns where the sensor saw a point of the middle row's frame; none if it is not in front of the lens.
std::optional<Vector2d> SeenAt(const ViewRows& rows, const CameraModel& camera, const Vector3d& in_middle) {
  std::optional<Vector2d> seen = camera.ImgFromCam(in_middle);
  for (int step = 0; step < kSeenSteps && seen; ++step)
    seen = camera.ImgFromCam(
        PointAfter(rows.twist, in_middle, RowTime(rows.readout_s, seen->y(), camera.height)));
  return seen;
}

}  // namespace

Rigid3 ViewRows::PoseAt(const CameraModel& camera, double row) const {
  return Perturbed(middle_from_world, RowTime(readout_s, row, camera.height) * twist);
}

std::map<int, ViewRows> RowsOfViews(const LightField& light_field) {
  std::map<int, ViewRows> rows;
  if (!light_field.readout || light_field.readout->readout_s == 0) return rows;
  for (const auto& [id, seen] : PointsOfMovingViews(light_field))
    if (auto of_view = FittedRows(light_field, *light_field.FindView(id), seen))
      rows.emplace(id, std::move(*of_view));
  return rows;
}

UndistortionMap InstantMap(const ViewRows& rows, const CameraModel& from, const CameraModel& to,
                           const cv::Mat& depth) {
  constexpr float kOutside = -1e4f;
  UndistortionMap map{cv::Mat(to.height, to.width, CV_32F, cv::Scalar(kOutside)),
                      cv::Mat(to.height, to.width, CV_32F, cv::Scalar(kOutside))};
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x) {
      const Vector2d img(x + 0.5, y + 0.5);
      const auto ray = to.RayFromImg(img);
      if (!ray || ray->z() <= 0) continue;
      const float known = depth.at<float>(y, x);
      double along = known;
      if (!(known > 0)) along = rows.depths.At(from.ImgFromCam(*ray).value_or(img));
      const auto seen = SeenAt(rows, from, *ray * (along / ray->z()));
      if (!seen) continue;
      map.x.at<float>(y, x) = static_cast<float>(seen->x() - 0.5);  // OpenCV counts from a pixel's centre
      map.y.at<float>(y, x) = static_cast<float>(seen->y() - 0.5);
    }
  return map;
}

LightField AtOneInstant(const LightField& light_field, const std::map<int, ViewRows>& rows) {
  LightField instant = light_field;
  for (View& view : instant.views)
    if (const auto found = rows.find(view.id); found != rows.end()) {
      view.cam_from_world = found->second.middle_from_world;
      view.twist.reset();
    }
  for (ScenePoint& point : instant.points)
    for (ViewObservation& seen : point.track) {
      const auto found = rows.find(seen.view_id);
      if (found == rows.end()) continue;
      const CameraModel& camera = light_field.CameraOf(*light_field.FindView(seen.view_id));
      const Vector3d in_middle = found->second.middle_from_world * point.position_in_world;
      const auto at_once = camera.ImgFromCam(in_middle), then = SeenAt(found->second, camera, in_middle);
      if (at_once && then) seen.in_img += *at_once - *then;
    }
  instant.readout.reset();
  return instant;
}

}  // namespace ulf::tracking
