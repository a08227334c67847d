// Makes points from pairwise matches, and measures them in every view that shows them.
//
// BuildTracks() joins the matches over all views, triangulates, and keeps as many points as the views need.
// But corner detection repeats for about half of the corners only, and wanders by half a pixel. So once poses
// are good to a pixel, ExtendTracks() warps each point's reference patch (from the middle one of its views)
// into every view in which it should appear and aligns it to a fraction of a pixel, in place of the corners.
#pragma once

#include <vector>

#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct TrackOptions {
  double gate_px = 4;  // largest reprojection error of an inlier; grows with the pyramid level. Guessed
  int min_views = 3;   // least number of views of a track: fewer agree by chance
  int per_view = 400;  // about the number of tracks a view, evenly over a grid of cells
};

// Joins matches to tracks, those with the nearest descriptors first, unless a track would get two corners of
// one view. Then triangulates and selects. Replaces scene.tracks.
void BuildTracks(const std::vector<PairMatches>& pairs, const TrackOptions& options, RefineScene& scene);

// Sets the track's position to the point on which most observations agree, and keeps only those. Returns
// false if fewer than `min_views` agree, or the largest parallax is below one degree.
bool TriangulateRobustly(const RefineScene& scene, const TrackOptions& options, SceneTrack& track);

// Measures the tracks in every view by their patches, and keeps those that at least two views show. Each view
// shows about `per_view` points afterwards, evenly over a grid, long tracks first.
void ExtendTracks(int per_view, RefineScene& scene);

}  // namespace ulf::tracking
