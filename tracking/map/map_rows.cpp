#include "tracking/map/map_rows.h"

#include <vector>

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// What a keyframe sees of the map, where its sensor saw it.
struct Sighting {
  int point;
  std::size_t observation;  // of the point
  Vector3d in_cam;
  Vector2d seen;
};

std::vector<Sighting> SightingsOf(const Map& map, int id) {
  const Keyframe& keyframe = map.keyframe(id);
  std::vector<Sighting> sightings;
  for (const int p : keyframe.point_of_feature) {
    if (p < 0) continue;
    const std::vector<Observation>& observations = map.point(p).observations;
    for (std::size_t o = 0; o < observations.size(); ++o) {
      if (observations[o].keyframe != id) continue;
      const Vector3d in_cam = keyframe.cam_from_world * map.point(p).position;
      const Vector2d& img = observations[o].img;
      sightings.push_back({p, o, in_cam, keyframe.rows ? keyframe.rows->Seen(img, in_cam) : img});
    }
  }
  return sightings;
}

void ReplaceRows(const CameraModel& camera, Map& map, int id, const std::vector<Sighting>& sightings,
                 std::shared_ptr<const RowShift> rows) {
  Keyframe& keyframe = map.keyframe(id);
  for (const Sighting& sighting : sightings)
    map.point(sighting.point).observations[sighting.observation].img =
        rows ? rows->Global(sighting.seen, sighting.in_cam) : sighting.seen;
  keyframe.features = MoveFeatures(camera, *keyframe.features, keyframe.rows.get(), rows.get());
  if (keyframe.pyramid) keyframe.pyramid = WithRows(*keyframe.pyramid, rows);
  keyframe.rows = std::move(rows);
}

DepthField DepthsOf(const CameraModel& camera, const std::vector<Sighting>& sightings) {
  std::vector<DepthField::Sample> depths;
  for (const Sighting& sighting : sightings)
    if (sighting.in_cam.z() > 0) depths.push_back({sighting.seen, sighting.in_cam.z()});
  return {camera, depths};
}

}  // namespace

void GiveRows(const CameraModel& camera, Map& map, double readout_s) {
  for (const int id : map.living()) {
    const Keyframe& keyframe = map.keyframe(id);
    if (!keyframe.velocity || (readout_s == 0 && !keyframe.rows)) continue;
    const std::vector<Sighting> sightings = SightingsOf(map, id);
    std::shared_ptr<const RowShift> rows;
    if (readout_s != 0)
      rows = std::make_shared<const RowShift>(camera, readout_s,
                                              keyframe.rows ? keyframe.rows->twist() : *keyframe.velocity,
                                              DepthsOf(camera, sightings));
    ReplaceRows(camera, map, id, sightings, std::move(rows));
  }
}

}  // namespace ulf::tracking
