#include "tracking/refine/refine_truth.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

double Tolerance(std::vector<TimedPose> truth, double most_s) {
  std::ranges::sort(truth, {}, &TimedPose::time_s);
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < truth.size(); ++i) steps_s.push_back(truth[i].time_s - truth[i - 1].time_s);
  return std::min(most_s, 0.5 * Median(std::move(steps_s)));
}

Vector3d MiddleOf(const std::vector<ScenePoint>& points) {
  Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> coordinates;
    for (const ScenePoint& point : points) coordinates.push_back(point.position_in_world(axis));
    middle(axis) = Median(std::move(coordinates));
  }
  return middle;
}

std::vector<std::pair<const char*, const TrajectoryError*>> TruthRows(const LightFieldErrors& errors) {
  std::vector<std::pair<const char*, const TrajectoryError*>> rows;
  if (errors.recorded) rows.emplace_back("recorded", &*errors.recorded);
  rows.emplace_back("before", &*errors.before);
  rows.emplace_back("after", &*errors.after);
  return rows;
}

}  // namespace

LightFieldErrors CompareWithTruth(const LightField& before, const RefineResult& result,
                                  const std::vector<TimedPose>& truth, const std::string& truth_name,
                                  double most_apart_s) {
  std::vector<TimedPose> recorded, old_poses, new_poses;
  for (std::size_t v = 0; v < before.views.size(); ++v) {
    const View& view = before.views[v];
    if (view.recorded_cam_from_world) recorded.push_back({view.device_time_s, *view.recorded_cam_from_world});
    old_poses.push_back({view.device_time_s, view.cam_from_world});
    new_poses.push_back({view.device_time_s, result.views[v].cam_from_world});
  }
  // The recorded poses of imported views are those before refining: one row suffices.
  const auto moved = [](const View& view) {
    const Rigid3& now = view.cam_from_world;
    return view.recorded_cam_from_world &&
           (view.recorded_cam_from_world->translation != now.translation ||
            view.recorded_cam_from_world->rotation.coeffs() != now.rotation.coeffs());
  };
  if (std::ranges::none_of(before.views, moved)) recorded.clear();
  const double tolerance_s = Tolerance(truth, most_apart_s);
  LightFieldErrors errors{truth_name, CompareTrajectories(recorded, truth, tolerance_s),
                          CompareTrajectories(old_poses, truth, tolerance_s),
                          CompareTrajectories(new_poses, truth, tolerance_s)};
  if (!errors.before || !errors.after)
    throw Error(
        "{}: fewer than three views have a true pose within {:.1f} ms of their device time, or they lie on a "
        "line: nothing is compared; give a truth in the device's clock",
        truth_name, 1e3 * tolerance_s);
  const Vector3d middle = errors.after->truth_from_estimated * MiddleOf(result.points);
  std::vector<double> distances;
  for (const TimedPose& pose : truth)
    distances.push_back((pose.cam_from_world.OriginInSource() - middle).norm());
  errors.distance = Median(std::move(distances));
  return errors;
}

nlohmann::ordered_json ToJson(const LightFieldErrors& errors) {
  nlohmann::ordered_json json{
      {"file", errors.truth_name}, {"compared", errors.after->matched}, {"distance", errors.distance}};
  for (const auto& [name, error] : TruthRows(errors))
    json[name] = {{"centre_rms", error->ate_rmse},
                  {"centre_median", error->ate_median},
                  {"centre_largest", error->ate_max},
                  {"centre_rms_percent", 100 * error->ate_rmse / errors.distance},
                  {"rotation_rms_deg", error->rotation_rmse_deg}};
  return json;
}

std::string ToText(const LightFieldErrors& errors) {
  std::string text =
      fmt::format("camera centres against {} ({}, its unit taken as metres, {:.3f} m from what they see):\n",
                  errors.truth_name, Counted(errors.after->matched, "view"), errors.distance);
  for (const auto& [name, error] : TruthRows(errors))
    text += fmt::format(
        "  {:<9} RMS {:.3f} mm ({:.4f} % of the distance), median {:.3f}, largest {:.3f}; turned by "
        "{:.4f} degrees\n",
        name, 1e3 * error->ate_rmse, 100 * error->ate_rmse / errors.distance, 1e3 * error->ate_median,
        1e3 * error->ate_max, error->rotation_rmse_deg);
  return text;
}

}  // namespace ulf::tracking
