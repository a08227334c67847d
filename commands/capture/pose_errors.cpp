#include "commands/capture/pose_errors.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/base/quantile.h"

namespace ulf::commands {

PoseErrors CompareWithTruth(const std::filesystem::path& truth_file, const std::vector<TimedPose>& live,
                            const LightField& light_field) {
  constexpr double kSameFrame_s = 0.002;  // times are the device's own in both
  const std::vector<TimedPose> truth = ReadTum(truth_file);
  std::vector<TimedPose> views;
  std::vector<double> distances;
  for (const View& view : light_field.views) {
    views.push_back({view.device_time_s, view.cam_from_world});
    if (light_field.subject)
      distances.push_back((view.CenterInWorld() - light_field.subject->center_in_world).norm());
  }
  PoseErrors errors{CompareTrajectories(live, truth, kSameFrame_s),
                    CompareTrajectories(views, truth, kSameFrame_s)};
  if (errors.views) errors.subject_distance = errors.views->scale * Median(std::move(distances));
  return errors;
}

void AddTo(nlohmann::json& json, const PoseErrors& errors) {
  const auto number = [](const std::optional<TrajectoryError>& error) {
    return error ? nlohmann::json(error->ate_rmse) : nlohmann::json(nullptr);
  };
  json["ate_live_rmse"] = number(errors.live);
  json["ate_views_rmse"] = number(errors.views);
  json["truth_subject_distance"] = errors.subject_distance;
}

std::string ToText(const PoseErrors& errors) {
  if (!errors.live || !errors.views || errors.subject_distance <= 0)
    return "against truth  too few poses have a true one at their time to compare\n";
  const double share = 100 / errors.subject_distance;
  return fmt::format(
      "against truth  camera centres off by {:.3f} % of the subject distance live ({}), {:.3f} % in the "
      "light field ({}), RMS\n",
      share * errors.live->ate_rmse, Counted(errors.live->matched, "frame"), share * errors.views->ate_rmse,
      Counted(errors.views->matched, "view"));
}

}  // namespace ulf::commands
