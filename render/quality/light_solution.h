// Solves for gains of views and fall-off of lenses from several views' light at the same points (light_fit.h
// has the model), without photographs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace ulf::render {

enum class LightModel { kAsRecorded, kGains, kGainsAndFalloff };

struct LightObservation {
  int view = 0, camera = 0;
  double r2 = 0;         // square of LightCorrection's r
  double log_light = 0;  // logarithm of the photograph's light
  double error = 1;      // expected error of log_light
};

// The observations of a point in one channel.
struct LightSample {
  int channel = 0;
  bool held_out = false;  // takes no part in the solution
  std::vector<LightObservation> seen = {};
};

struct LightSolution {
  std::array<std::vector<double>, 3> log_gain;  // by channel and view; their mean over the views is 0
  std::vector<Eigen::Vector2d> falloff;         // by camera: a and b
};

double FalloffOf(const Eigen::Vector2d& falloff, double r2);  // 1 + a r^2 + b r^4

LightSolution SolveLight(const std::vector<LightSample>& samples, int views, int cameras, LightModel model);

// Returns, for each observation of held-out points, the difference from the point's median observation after
// correction.
struct HeldOutError {
  double over_expected = 0, expected = 1;
};
std::vector<HeldOutError> HeldOutErrors(const std::vector<LightSample>& samples,
                                        const LightSolution& solution);

}  // namespace ulf::render
