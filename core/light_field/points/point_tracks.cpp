#include "core/light_field/points/point_tracks.h"

#include <algorithm>
#include <unordered_map>

#include "core/light_field/points/point_fit.h"

namespace ulf {
namespace {

class ObservationsById {
 public:
  explicit ObservationsById(const LightField& light_field) : light_field_(light_field) {
    for (const View& view : light_field.views) views_[view.id] = &view;
  }
  // Without a camera: there is no such view.
  PosedObservation Of(const ViewObservation& seen) const {
    const auto view = views_.find(seen.view_id);
    if (view == views_.end()) return {};
    return {&light_field_.CameraOf(*view->second), &view->second->cam_from_world, seen.in_img};
  }

 private:
  const LightField& light_field_;
  std::unordered_map<int, const View*> views_;
};

}  // namespace

void FitPointsOf(const std::set<int>& view_ids, LightField& light_field) {
  if (view_ids.empty()) return;
  const ObservationsById observations_by_id(light_field);
  std::erase_if(light_field.points, [&](ScenePoint& point) {
    const bool moved = std::ranges::any_of(
        point.track, [&](const ViewObservation& seen) { return view_ids.contains(seen.view_id); });
    if (!moved) return false;
    std::vector<PosedObservation> observations;
    for (const ViewObservation& seen : point.track)
      if (const PosedObservation observation = observations_by_id.Of(seen); observation.camera)
        observations.push_back(observation);
    const auto position = FitPoint(observations);
    if (position) point.position_in_world = *position;
    return !position;
  });
}

std::size_t MeasurePoints(LightField& light_field) {
  const ObservationsById observations_by_id(light_field);
  std::size_t misplaced = 0;
  for (ScenePoint& point : light_field.points) {
    double sum_px = 0;
    std::erase_if(point.track, [&](const ViewObservation& seen) {
      const PosedObservation observation = observations_by_id.Of(seen);
      if (!observation.camera) return true;
      const double error_px = ReprojectionErrorPx(observation, point.position_in_world);
      if (!(error_px <= kMostTrackErrorPx)) {
        ++misplaced;
        return true;
      }
      sum_px += error_px;
      return false;
    });
    if (point.track.size() < 2) point.track.clear();
    point.error_px = point.track.empty() ? 0 : sum_px / static_cast<double>(point.track.size());
  }
  return misplaced;
}

PointStatistics StatisticsOf(const std::vector<ScenePoint>& points) {
  PointStatistics statistics;
  statistics.points = points.size();
  double sum_px = 0;
  for (const ScenePoint& point : points) {
    statistics.tracked += !point.track.empty();
    statistics.observations += point.track.size();
    sum_px += point.error_px * static_cast<double>(point.track.size());
  }
  if (statistics.observations == 0) return statistics;
  const double observations = static_cast<double>(statistics.observations);
  statistics.mean_track_length = observations / static_cast<double>(statistics.tracked);
  statistics.mean_error_px = sum_px / observations;
  return statistics;
}

}  // namespace ulf
