// Makes points from pairwise matches: joins the matches over all views, triangulates, and keeps as many
// points as the views need.
#pragma once

#include <vector>

#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct TrackOptions {
  double gate_px = 4;           // of reprojection; grows with the pyramid level. Guessed
  int min_views = 3;            // fewer agree by chance
  double min_parallax_deg = 1;  // largest between two of a track's views; less leaves its depth open. Guessed
  int per_view = 400;           // about so many tracks a view, evenly over a grid of cells
  int columns = 10, rows = 8;   // of that grid: more spread the tracks more evenly. Guessed
  int tried_pairs = 12;         // of observations, where not all agree: more cost time. Guessed
};

// Joins matches, those with the nearest descriptors first, except where a track would get two corners of one
// view. Then triangulates and selects. Replaces scene.tracks.
void BuildTracks(const std::vector<PairMatches>& pairs, const TrackOptions& options, RefineScene& scene);

// Finds the point that most observations agree on, and keeps only those; false where fewer than min_views do,
// or the parallax is too small.
bool TriangulateRobustly(const RefineScene& scene, const TrackOptions& options, SceneTrack& track);

}  // namespace ulf::tracking
