// Solves for the gains of views and the fall-off of lenses, given the light of points in several views
// (light_fit.h has the model).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace ulf::render {

enum class LightModel { kAsRecorded, kGains, kGainsAndFalloff };

struct LightObservation {
  int view = 0, camera = 0;  // numbers from 0
  double r2 = 0;             // square of LightCorrection's r
  double log_light = 0;      // logarithm of the photograph's light
  double error = 1;          // expected error of log_light
};

// The observations of a point in one channel.
struct LightSample {
  int channel = 0;
  bool held_out = false;  // takes no part in the solution
  std::vector<LightObservation> seen = {};
};

struct LightSolution {
  // By channel (B G R) and view; the mean over the views is 0 in each channel.
  std::array<std::vector<double>, 3> log_gain;
  std::vector<Eigen::Vector2d> falloff;  // by camera: a and b
};

double FalloffOf(const Eigen::Vector2d& falloff, double r2);  // 1 + a r^2 + b r^4

LightSolution SolveLight(const std::vector<LightSample>& samples, int views, int cameras, LightModel model);

// An observation's difference from the median of its point after correction, over the expected one.
struct HeldOutError {
  double over_expected = 0, expected = 1;  // the latter: LightObservation::error
};
// Returns the errors of all observations of held-out points.
std::vector<HeldOutError> HeldOutErrors(const std::vector<LightSample>& samples,
                                        const LightSolution& solution);

}  // namespace ulf::render
