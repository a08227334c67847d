// Compensates a rolling shutter in a map that was made without it.
#pragma once

#include <memory>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// A keyframe's observation of a point, where its sensor saw it.
struct RowObservation {
  int point;
  std::size_t observation;  // of the point
  Eigen::Vector3d in_cam;
  Eigen::Vector2d seen;
};

DepthField DepthsOf(const CameraModel& camera, const std::vector<RowObservation>& row_observations);

// Replaces a keyframe's row shift (null: none) and moves its observations. The caller holds the map's lock.
void ReplaceRows(const CameraModel& camera, Map& map, int id,
                 const std::vector<RowObservation>& row_observations, std::shared_ptr<const RowShift> rows);

// Replaces the row shift of every keyframe with a known velocity by one of this readout (0: none), and moves
// its observations. The caller holds the map's lock.
void GiveRows(const CameraModel& camera, Map& map, double readout_s);

}  // namespace ulf::tracking
