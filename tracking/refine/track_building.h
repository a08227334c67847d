// Makes points from pairwise matches, and measures them in every view that shows them.
//
// Building joins the matches over all views, triangulates, and keeps as many points as the views need. But
// corner detection repeats for about half of the corners only, and wanders by half a pixel. So with poses
// good to a pixel each point's reference patch (from the middle one of its views) is warped into every view
// in which it should appear and aligned to a fraction of a pixel. These measurements replace the detected
// corners.
#pragma once

#include <vector>

#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct TrackOptions {
  double gate_px = 4;  // reprojection error of an inlier, at most; grows with the pyramid level. Guessed
  int min_views = 3;   // views of a track, at least: fewer agree by chance
  int per_view = 400;  // about so many tracks a view, evenly over a grid of cells
};

// Joins matches, those with the nearest descriptors first, except where a track would get two corners of one
// view. Then triangulates and selects. Replaces scene.tracks.
void BuildTracks(const std::vector<PairMatches>& pairs, const TrackOptions& options, RefineScene& scene);

// Finds the point that most observations agree on, and keeps only those; false where fewer than min_views do,
// or the parallax is too small.
bool TriangulateRobustly(const RefineScene& scene, const TrackOptions& options, SceneTrack& track);

// Measures the tracks in every view by their patches, and keeps those that two views show at least.
// `per_view`: about how many points each view shows afterwards, evenly over a grid, long tracks first.
void ExtendTracks(int per_view, RefineScene& scene);

}  // namespace ulf::tracking
