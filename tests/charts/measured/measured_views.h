// Simulated scenes with a light field that a hand has recorded, and frames that it saw besides: what
// render/prediction measures at these frames, and what is true there. Frames have noise, and poses the error
// that is asked for; true pictures and depths have neither.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"
#include "render/prediction/prediction_error.h"
#include "render/scene/scene.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct RecordedOptions {
  std::string scene = "studio";
  std::uint64_t seed = 1;
  double view_spacing = Radians(6);  // directions of recorded views are at least this far apart
  double pose_error_px = 0.3;        // of recorded views and of frames, at the subject, 640 pixels wide
  int frames = 24;
};

struct FrameMeasurement {
  PredictionError measured;
  double true_db = 0;        // of the renderer's picture, on the subject's disc, display-encoded grey
  double true_small_db = 0;  // the same of both pictures reduced and smoothed as those that are measured
  double true_outside_db = 0;
  double true_px = 0;     // displacement on the disc, pixels of 320: root mean square, views by their weight
  double measure_ms = 0;  // processor time
};

struct MeasuredScene {
  int views = 0;
  std::size_t triangles = 0;
  std::vector<FrameMeasurement> frames;
};

MeasuredScene MeasureFrames(const RecordedOptions& options);

}  // namespace ulf::test
