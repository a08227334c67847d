// Defines the options of the tracker that commands, tests or charts vary; other thresholds are constants in
// the sources. "Measured" names the chart; "guessed" values were set once and worked.
#pragma once

#include <optional>

#include "tracking/features/features.h"
#include "tracking/map/mapper_options.h"

namespace ulf::tracking {

// What is known of a rolling shutter. Readout times run from the first row to the last; if they are negative,
// the last row is read first.
struct ReadoutArgs {
  std::optional<double> readout_s = {};  // 0: a global shutter; none: the tracker measures it
  bool compensate_found = true;  // a readout that the tracker finds is compensated, else only reported
};

// The tracker treats a given lens so if the map's images contradict it.
enum class LensUse {
  kFixed,  // it is not checked
  kCheck,  // the tracker reports the contradiction
  // The tracker goes on with the lens that fits, and poses follow. A rolling shutter that is found is
  // compensated in any case, because it looks like another lens.
  kRefine
};

struct TrackerOptions {
  bool deterministic = false;  // mapping runs inside Step(): the same frames give the same bytes
  unsigned seed = 1;           // of every random draw
  // Number of corners a frame, doubled while a map starts. Measured: docs/measured/charts/tracking.png.
  int features = 850;
  // Images with a longer side are reduced to it; 0: they are tracked as they come. Measured:
  // docs/measured/charts/tracking_side.png.
  int max_side_px = 960;
  // A live camera does not wait: when the mapper is behind, keyframes are left out. A replay, whose frames
  // come faster than a camera's, waits for the mapper before every frame and leaves none out.
  bool wait_for_mapper = false;
  ReadoutArgs readout = {};
  LensUse lens = LensUse::kCheck;
  // The given lens is no calibration (a focal length from Exif data, a data sheet, a guess). With
  // LensUse::kRefine it is replaced as soon as the map determines a better one, contradicted or not.
  bool lens_is_guess = false;
  // A camera that stays lost begins another part of the map; else it stays lost until it is back.
  bool begin_parts = true;

  FeatureOptions corners = {};
  MapperOptions mapping = {};
};

}  // namespace ulf::tracking
