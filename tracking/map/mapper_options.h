// What the mapper decides by: when a frame becomes a keyframe, which points are made and kept, how far an
// adjustment reaches, and when a loop is believed.
//
// Lengths are shares of the scene's depth where no unit is given. "Measured" values are charted against
// accuracy on two recordings (docs/charts/map_size.png; docs/tracking_measured.md, "The map"); "guessed" ones
// were set once and worked.
#pragma once

#include <cstddef>

#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

// A bundle adjustment's iterations before and after outliers are dropped.
struct AdjustmentEffort {
  int robust_iterations = 0, iterations = 0;
};

// A given world holds the map where at least so many keyframes show at least so many corners, from centres
// that are spread by this share of their distance. Fewer leave the scale to chance. Guessed.
struct GivenWorldOptions {
  std::size_t min_corners = 4;
  int min_views = 3;
  double min_spread = 0.02;
};

// Measuring a rolling shutter from the map's keyframes (readout_estimator.h). Guessed.
struct ReadoutOptions {
  int most_keyframes = 24, least_keyframes = 5;  // newest ones with a velocity; fewer tell nothing
  double huber_sigmas = 2;
};

// Loops (loop_closer.h).
struct LoopOptions {
  // Keyframes that must say the same before a loop is closed, and how many keyframes a statement stays valid.
  // Fewer close loops between places that look alike, more close them late. Guessed.
  int agreeing = 3, memory = 8;
  // Median distance between two corrections of the points, of their distance. Guessed.
  double agreement = 0.05;
  int rest = 5;  // keyframes after a closed loop without another search. Guessed
  // Candidates: the best ranked that are looked at, and the places among them that are verified. Guessed.
  int ranked = 30, candidates = 3;
  // Points to verify a candidate by: matched descriptors, matches that fit one similarity, points that guided
  // matching finds, and pairs that tell the scale. Fewer prove nothing. Guessed.
  int min_matches = 20, min_sampled = 15, min_points = 40, min_scale_pairs = 15;
  // The same of two parts of the map, of which the younger one knows few points yet. Guessed.
  int min_join_points = 20, min_join_scale_pairs = 10;
  double max_log_scale_spread = 0.1;  // median deviation; above it the pairs tell no scale. Guessed
  int max_distance = 70;              // bits, of matched descriptors
  double max_ratio = 0.85;
  double sampled_sigmas = 4;  // within which a match fits a similarity. Guessed
  int samples = 300;
  // Larger corrections are no drift, but another place. Guessed.
  double max_drift = 0.25;      // the correction's length, of the way since the old part was seen
  double max_turn_deg = 35;     // of the correction
  double max_scale_change = 2;  // of the correction, either way
  // The pose graph: each keyframe's ties to earlier ones that share at least so many points, or that lie so
  // many keyframes back (earlier loops); the weight of keyframes that share none; the weight of the new loop,
  // which must hold against many parallel ties. Guessed.
  int strong_tie = 60, old_tie = 20;
  double loose_weight = 0.1, loop_weight = 100;
  int neighbourhood = 12;  // keyframes on either side whose points are known or merged. Guessed
};

struct MapperOptions {
  // A keyframe is offered when the camera has moved or turned so far since the nearest keyframe. Measured.
  double keyframe_moved = 0.03;
  double keyframe_turned_deg = 10;
  // It is offered sooner when the frame has less than this share of the nearest keyframe's points, or fewer
  // points than this, and the camera has moved or turned at least so far. Guessed.
  double thin_share = 0.75;
  int thin_points = 80;
  double thin_moved = 0.02;
  double thin_turned_deg = 4;
  // The frame after a keyframe is none, unless it comes so much later: then the camera has moved on. Guessed.
  double next_frame_after_s = 0.07;
  bool check_lens = true;  // against the map as it grows (lens_watch.h)
  bool seek_lens =
      false;  // the given one is a guess: SharedMap::lens_is_due says when the map may tell another

  // A keyframe goes when more than this share of its points are seen by so many others, on the same pyramid
  // level, a finer one, or the next coarser one. The newest ones stay. Measured (the share), guessed.
  double superfluous_share = 0.9;
  int superfluous_others = 3;
  int newest_kept = 2;

  // A point goes within its first keyframes when it is found in less than this share of the frames that
  // should have seen it (once those are enough to tell), or when no third keyframe sees it. Measured (the
  // share), guessed. Ages are keyframes since the point was made.
  double min_found_share = 0.25;
  int min_expected = 8;
  int confirmed_age = 3, settled_age = 4;

  // New points. Two views make one where their rays meet at this angle; smaller angles leave the depth open.
  // Measured.
  double min_parallax_deg = 1;
  // Neighbours that points are made with, and merged with: the keyframes that share most points, at least so
  // many. More cost time. Guessed.
  int triangulate_with = 8, fuse_with = 12, min_shared = 12;
  double min_baseline = 0.01;  // between two views, of the depth; closer views tell no depth. Guessed
  // Sine of the angle from the epipole: lines are undefined there. Guessed.
  double min_epipole_distance = 0.02;
  double epipolar_sigmas = 2;  // a match lies so close to its epipolar line. Guessed
  double max_ratio = 0.9;      // best descriptor distance / second best. Guessed
  // A twin in the same image within this share of the best distance makes the match ambiguous. Guessed.
  double twin_distance_share = 4.0 / 3;
  double max_level_mismatch = 1.8;  // ratio of distances against ratio of pyramid scales. Guessed
  // Merging: a point is looked for within this radius (level pixels) in keyframes that see it from less than
  // 60 degrees aside (as a cosine). Guessed.
  double fuse_radius_px = 3;
  double fuse_min_cosine = 0.5;
  int pyramids_kept = 12;  // newest keyframes whose images are kept for alignment. Guessed

  // Adjustment of a new keyframe's neighbourhood: keyframes that move, keyframes that hold them. Guessed.
  int local_keyframes = 14, held_keyframes = 20;
  int dense_cameras = kDenseCameras;
  AdjustmentEffort local{4, 6};
  // The whole map is adjusted when it has grown by this factor since it last was. Guessed.
  double adjust_all_growth = 1.1;
  // Of a map's two first views; of a growing map, where each adjustment continues the one before; after a
  // closed loop and at the end, which start far off; of a map made from given poses. Guessed.
  AdjustmentEffort two_views{15, 15}, growing{5, 10}, moved{10, 40}, seeded{10, 10};
  AdjustmentEffort with_lens{40, 40};  // of a map whose lens was wrong
  // A growing map needs even measurements that are a little off; a finished one does not: at the end
  // Cauchy's loss begins to doubt at so many times the errors' own scale. Measured (docs/tracking_measured.md,
  // "Cauchy's loss").
  double final_cauchy_scales = 2;
  // A map made from given poses: neighbours look the same way (as a cosine), and points are adjusted after so
  // many views. Guessed.
  double seed_min_cosine = 0.5;
  int seeds_between_adjustments = 8;

  GivenWorldOptions given_world = {};
  ReadoutOptions readout = {};
  LoopOptions loops = {};
};

}  // namespace ulf::tracking
