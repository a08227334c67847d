// How bright each photograph is beside the others, and how much darker a lens leaves its corners, for all views
// together: imported sets say nothing of exposure, and a phone changes it from picture to picture.
//
// Points of the proxy's surface that several views see should send the same light to all of them. Where they do not,
//
//   log light(view, channel) = log light(point, channel) + gain(view, channel) + log(1 + a r^2 + b r^4)
//
// is solved for the gains, whose mean over the views is 0 in each channel, and for a and b of each camera
// (r: LightCorrection). Highlights, what moved and what the proxy has wrong are outliers: weights are those of the
// absolute deviation first, then Geman and McClure's. Points that took no part decide how much of the model is needed:
// nothing, gains, or gains and fall-off.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/model_choice.h"
#include "render/scene/scene.h"

namespace ulf::render {

enum class LightModel { kAsRecorded, kGains, kGainsAndFalloff };

struct LightFitOptions {
  int points_per_view = 400;  // tried; their number sets the error, which falls with its root. Guessed.
  int most_points = 40000;    // in all: their number sets the time. Guessed.
  int views_per_point = 8;    // at most, of those that see it. Guessed.
  int most_asked = 64;        // views that are asked whether they see a point. Guessed.
  int size_px = 480;          // longer side of the pictures that are compared, at most: as proxies are made
  // Light outside of these is not compared: clipped, or mostly noise. Shares of white. Guessed.
  float least_light = 0.01f, most_light = 0.95f;
  // Of the log of light: what points differ by where the picture is smooth; where it is not, what a misplacement
  // by a pixel changes counts as well. Guessed.
  double smooth_error = 0.02;
  // The simplest model is kept whose error at held-out points is within this share, or this much, of the best.
  // Guessed; the second is a quarter of a level of 255.
  double within_share = 0.03, within = 0.001;
};

struct LightFit {
  LightModel model = LightModel::kAsRecorded;
  std::map<int, cv::Vec3f> gains = {};                                 // B G R, by SceneView::id
  std::vector<std::pair<CameraModel, Eigen::Vector2f>> falloffs = {};  // a and b
  std::size_t points = 0;
  double stops = 0;         // between the darkest and the brightest view, in the channel where that is most
  double corner_stops = 0;  // by which corners are darker, most of all cameras
  ModelChoice explained = {};

  std::string Words() const;  // what was found, in a clause
};

// `scene`: over a proxy with triangles, with its shadow maps (WithProxy). A proxy without triangles, or one on which
// views have no points in common, leaves everything as recorded.
LightFit FitLight(const RenderScene& scene, const LightFitOptions& options = {});

// The scene with the corrections. A view that was not fitted, such as one that is left out and compared, has the
// fall-off of its camera where another view has the same one, and a gain of 1: how it was exposed cannot be known. An
// automatic exposure follows what the camera sees, though: where the fitted views' gains follow from their neighbours'
// (each predicted without itself), so does this one.
std::shared_ptr<const RenderScene> WithLight(const RenderScene& scene, const LightFit& fit);

// The steps of FitLight() between photographs and corrections, for tests.
struct LightObservation {
  int view = 0, camera = 0;
  double r2 = 0;         // LightCorrection's r, squared
  double log_light = 0;  // as the photograph has it
  double error = 1;      // expected, of log_light
};
struct LightSample {  // of a point, in one channel
  int channel = 0;
  bool held_out = false;
  std::vector<LightObservation> seen = {};
};
struct LightSolution {
  std::array<std::vector<double>, 3> log_gain;  // by channel and view
  std::vector<Eigen::Vector2d> falloff;         // by camera
};
LightSolution SolveLight(const std::vector<LightSample>& samples, int views, int cameras, LightModel model);

}  // namespace ulf::render
