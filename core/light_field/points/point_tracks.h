// Updates a light field's points for its poses. The observations (tracks) are measurements and stay;
// positions and errors are computed from them and the present poses.
#pragma once

#include <set>

#include "core/light_field/light_field.h"

namespace ulf {

// Observations with a larger reprojection error are removed, as in COLMAP's mapper (its default).
inline constexpr double kMostTrackErrorPx = 4;

// Computes the positions of all points observed by these views again; removes points that cannot be
// triangulated.
void FitPointsOf(const std::set<int>& view_ids, LightField& light_field);

// Removes observations of missing views and those with larger errors than kMostTrackErrorPx, and sets every
// point's error. A track of one observation is removed too; the point stays. Returns how many errors were larger.
std::size_t MeasurePoints(LightField& light_field);

// Statistics of all points.
struct PointStatistics {
  std::size_t points = 0, tracked = 0, observations = 0;
  double mean_track_length = 0;  // of points with a track
  double mean_error_px = 0;      // of observations
};
PointStatistics StatisticsOf(const std::vector<ScenePoint>& points);

}  // namespace ulf
