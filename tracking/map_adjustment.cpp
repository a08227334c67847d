#include "tracking/map_adjustment.h"

#include <spdlog/spdlog.h>

#include <unordered_map>
#include <utility>

namespace ulf {

BundleSummary AdjustMap(const CameraModel& camera, SharedMap& shared, const std::vector<int>& free,
                        const std::vector<int>& held, const BundleOptions& options) {
  Map& map = shared.map;
  BundleProblem problem;
  std::unordered_map<int, int> camera_index, point_index;
  std::vector<int> point_ids;
  std::vector<std::pair<int, int>> origin;  // point id and keyframe of each observation
  const auto add_camera = [&](int id, bool fixed) {
    camera_index[id] = static_cast<int>(problem.cam_from_world.size());
    problem.cam_from_world.push_back(map.keyframe(id).cam_from_world);
    problem.fixed.push_back(fixed || map.keyframe(id).pinned);
  };
  // The first keyframe holds the world where it takes part.
  for (const int id : free) add_camera(id, id == map.FirstKeyframe());
  for (const int id : held) add_camera(id, true);
  const std::vector<int>& owners = free.empty() ? held : free;
  for (const int keyframe : owners)
    for (const int id : map.keyframe(keyframe).point_of_feature) {
      if (id < 0 || point_index.contains(id)) continue;
      point_index[id] = static_cast<int>(point_ids.size());
      point_ids.push_back(id);
    }
  for (const int id : point_ids) {
    const MapPoint& point = map.point(id);
    problem.points.push_back(point.position);
    for (const Observation& o : point.observations) {
      const auto seen_by = camera_index.find(o.keyframe);
      if (seen_by == camera_index.end()) continue;
      problem.observations.push_back({seen_by->second, point_index[id], o.img, o.sigma_px, false});
      origin.emplace_back(id, o.keyframe);
    }
  }
  const BundleSummary summary = AdjustBundle(camera, problem, options);
  spdlog::debug(
      "bundle: {} cameras ({} held), {} points, {} observations: {:.3f} -> {:.3f} sigmas, {} outliers",
      problem.cam_from_world.size(), held.size(), problem.points.size(), problem.observations.size(),
      summary.initial_rms_sigmas, summary.final_rms_sigmas, summary.outliers);
  if (!summary.usable) return summary;

  const std::lock_guard lock(shared.mutex);
  for (const auto& [id, index] : camera_index)
    map.keyframe(id).cam_from_world = problem.cam_from_world[static_cast<std::size_t>(index)];
  for (std::size_t i = 0; i < point_ids.size(); ++i) map.point(point_ids[i]).position = problem.points[i];
  for (std::size_t i = 0; i < origin.size(); ++i)
    if (problem.observations[i].outlier && map.point(origin[i].first).alive)
      map.Forget(origin[i].first, origin[i].second);
  for (const int id : point_ids) map.Update(id);
  return summary;
}

}  // namespace ulf
