// Changes the compensation of a rolling shutter in the keyframes of a map.
#pragma once

#include <memory>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// A keyframe's observation of a point, where its sensor saw it.
struct RowObservation {
  int point;
  std::size_t observation;  // index into MapPoint::observations
  Eigen::Vector3d in_cam;   // the point in the keyframe's frame
  Eigen::Vector2d seen;
};

DepthField DepthsOf(const CameraModel& camera, const std::vector<RowObservation>& row_observations);

// Replaces a keyframe's row shift (null: none), moves features and observations. Hold the map's lock.
void ReplaceRows(const CameraModel& camera, Map& map, int id,
                 const std::vector<RowObservation>& row_observations, std::shared_ptr<const RowShift> rows);

// Does so for every keyframe with a row shift or a known velocity, with this readout (0: no shift).
void GiveRows(const CameraModel& camera, Map& map, double readout_s);

}  // namespace ulf::tracking
