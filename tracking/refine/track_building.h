// Points from pairwise matches: joined over all views, triangulated from many, and thinned out to what the
// views need.
#pragma once

#include <vector>

#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct TrackOptions {
  double gate_px = 4;  // of reprojection; grows with the pyramid level
  int min_views = 3;
  double min_parallax_deg = 1;  // largest between two of its views
  int per_view = 400;           // about so many tracks a view, evenly over the image
};

// Joins matches, the surest first; one that would put two corners of a view into a track is left out. Then
// triangulates and selects. Replaces scene.tracks.
void BuildTracks(const std::vector<PairMatches>& pairs, const TrackOptions& options, RefineScene& scene);

// The point that most of the observations agree on, and only those; false where fewer than min_views do, or
// parallax is too small.
bool TriangulateRobustly(const RefineScene& scene, const TrackOptions& options, SceneTrack& track);

}  // namespace ulf::tracking
