#include "tracking/map/map_rows.h"

#include <vector>

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<RowObservation> RowObservationsOf(const Map& map, int id) {
  const Keyframe& keyframe = map.keyframe(id);
  std::vector<RowObservation> row_observations;
  for (const int p : map.PointsSeenBy(id)) {
    const std::vector<Observation>& observations = map.point(p).observations;
    for (std::size_t o = 0; o < observations.size(); ++o) {
      if (observations[o].keyframe != id) continue;
      const Vector3d in_cam = keyframe.cam_from_world * map.point(p).position;
      const Vector2d& img = observations[o].img;
      row_observations.push_back({p, o, in_cam, keyframe.rows ? keyframe.rows->Seen(img, in_cam) : img});
    }
  }
  return row_observations;
}

}  // namespace

void ReplaceRows(const CameraModel& camera, Map& map, int id,
                 const std::vector<RowObservation>& row_observations, std::shared_ptr<const RowShift> rows) {
  Keyframe& keyframe = map.keyframe(id);
  for (const RowObservation& row_observation : row_observations)
    map.point(row_observation.point).observations[row_observation.observation].img =
        rows ? rows->Global(row_observation.seen, row_observation.in_cam) : row_observation.seen;
  keyframe.features = MoveFeatures(camera, *keyframe.features, keyframe.rows.get(), rows.get());
  if (keyframe.pyramid) keyframe.pyramid = WithRows(*keyframe.pyramid, rows);
  keyframe.rows = std::move(rows);
}

DepthField DepthsOf(const CameraModel& camera, const std::vector<RowObservation>& row_observations) {
  std::vector<DepthField::Sample> depths;
  for (const RowObservation& row_observation : row_observations)
    if (row_observation.in_cam.z() > 0) depths.push_back({row_observation.seen, row_observation.in_cam.z()});
  return {camera, depths};
}

void GiveRows(const CameraModel& camera, Map& map, double readout_s) {
  for (const int id : map.living()) {
    const Keyframe& keyframe = map.keyframe(id);
    if (!keyframe.rows && (!keyframe.velocity || readout_s == 0)) continue;
    const std::vector<RowObservation> row_observations = RowObservationsOf(map, id);
    std::shared_ptr<const RowShift> rows;
    if (readout_s != 0)
      rows = std::make_shared<const RowShift>(camera, readout_s,
                                              keyframe.rows ? keyframe.rows->twist() : *keyframe.velocity,
                                              DepthsOf(camera, row_observations));
    if (!keyframe.expected_twist && rows) map.keyframe(id).expected_twist = rows->twist();
    ReplaceRows(camera, map, id, row_observations, std::move(rows));
  }
}

}  // namespace ulf::tracking
