// A light field's points against its poses. What a picture shows (a point's track) stays as it was seen;
// where the point is, and how far off its observations are, follow from it and from the poses there are now:
// neither can be older than they are.
#pragma once

#include <set>

#include "core/light_field/light_field.h"

namespace ulf {

// Of observations that are farther from their projection a point is not worth more: COLMAP's mapper drops
// those, too.
inline constexpr double kMostTrackErrorPx = 4;

// Points that one of these views shows are put where the poses have them now; those that then are nowhere go.
void FitPointsOf(const std::set<int>& view_ids, LightField& light_field);

// Takes out observations of views that are not there (any more) or that are farther off than that, and sets
// every point's error. A track of one observation says nothing and goes, too; the point stays.
void MeasurePoints(LightField& light_field);

// Of all points.
struct PointStatistics {
  std::size_t points = 0, tracked = 0, observations = 0;
  double mean_track_length = 0;  // of those that are tracked
  double mean_error_px = 0;      // of observations
};
PointStatistics StatisticsOf(const std::vector<ScenePoint>& points);

}  // namespace ulf
