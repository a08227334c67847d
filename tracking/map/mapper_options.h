// Defines the thresholds of the mapper that charts or commands vary; others are constants in the sources.
//
// "Measured" values are charted against accuracy on two recordings (docs/measured/charts/map_size.png;
// docs/measured/tracking.md, "The map"); "guessed" ones were set once and worked.
#pragma once

#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

struct MapperOptions {
  // A frame is offered as a keyframe when the camera has moved (share of the median depth) or turned so far
  // from the nearest keyframe. Measured.
  double keyframe_moved = 0.03;
  double keyframe_turned_deg = 10;
  // A keyframe is removed when more than this share of its points is seen by three others. Measured.
  double superfluous_share = 0.9;
  // A young point is removed when it is found in less than this share of the frames that should show it.
  // Measured.
  double min_found_share = 0.25;
  // The least angle between two rays that make a point; smaller ones leave the depth open. Measured.
  double min_parallax_deg = 1;
  int local_keyframes = 14;           // number that is adjusted for a new one, itself included. Guessed
  int dense_cameras = kDenseCameras;  // BundleOptions::dense_cameras
  bool check_lens = true;             // checks the lens against the map as it grows (lens_watch.h)
  // The given lens is a guess: sets SharedMap::lens_is_due when the map may tell a better one.
  bool seek_lens = false;
};

}  // namespace ulf::tracking
