// Defines the thresholds of the mapper that charts or commands vary; the others are constants in mapper.cpp,
// mapper_points.cpp and loop_closer.cpp.
//
// Lengths are shares of the scene's depth. "Measured" values are charted against accuracy on two recordings
// (docs/measured/charts/map_size.png; docs/measured/tracking.md, "The map"); "guessed" ones were set once and
// worked.
#pragma once

#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

struct MapperOptions {
  // A frame is offered as a keyframe when the camera has moved or turned so far since the nearest keyframe.
  // Measured.
  double keyframe_moved = 0.03;
  double keyframe_turned_deg = 10;
  // A keyframe is removed when more than this share of its points is seen by enough other keyframes.
  // Measured.
  double superfluous_share = 0.9;
  // A young point is removed when it is found in less than this share of the frames that should show it.
  // Measured.
  double min_found_share = 0.25;
  // Two views make a point where their rays meet at this angle; smaller angles leave the depth open.
  // Measured.
  double min_parallax_deg = 1;
  // Keyframes that are adjusted together with a new one. Guessed.
  int local_keyframes = 14;
  int dense_cameras = kDenseCameras;  // BundleOptions::dense_cameras
  bool check_lens = true;             // the lens is checked against the map as it grows (lens_watch.h)
  // The given lens is a guess: SharedMap::lens_is_due says when the map may tell a better one.
  bool seek_lens = false;
};

}  // namespace ulf::tracking
