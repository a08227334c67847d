// Checks whether the images contradict the given lens: its focal length, the first coefficient of its
// distortion, and its principal point.
//
// A wrong lens bends the whole world and leaves residuals that look like noise. The check frees intrinsics in
// three bundle adjustments: the focal length, also k1, also the principal point. It calls a number wrong if
// it differs by a share that matters and by many standard deviations; the focal length must differ in the
// first two. Flat scenes and sideways motion leave the lens undetermined; then standard deviations are large
// and nothing is called wrong.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

struct CalibrationCheck {
  double given_focal_px = 0;
  double fitted_focal_px = 0;
  double sigma_px = 0;      // one standard deviation of the fitted focal length
  bool determined = false;  // the geometry determines the focal length: sigma is below half a per cent
  double given_k1 = 0, fitted_k1 = 0, k1_sigma = 0;
  // Principal points.
  Eigen::Vector2d given_center_px = Eigen::Vector2d::Zero(), fitted_center_px = Eigen::Vector2d::Zero();
  double center_sigma_px = 0;
  bool focal_wrong = false, distortion_wrong = false, center_wrong = false;
  // What fits the images is no plausible lens (IsPlausible()); then no single number is called wrong.
  bool no_lens_fits = false;
  bool Wrong() const { return focal_wrong || distortion_wrong || center_wrong || no_lens_fits; }
  // The error of the cameras' centres as a share of the distance of what they see: 1.5 times how far they
  // move when the lens is freed, because a map that was made under the given lens holds them back.
  double error_share = 0;
  // Set by the caller: a rolling shutter was found and not compensated. It stretches images as another focal
  // length does, and the reverse.
  bool rows_uncompensated = false;

  // Returns the check in pixels of `resized`, the same camera with images of another size.
  CalibrationCheck Of(const CameraModel& resized) const;
  // Returns "images fit a focal length of 551.2 px (± 1.3) or more, 5.0 % above the 525.0 given", "images fit
  // a distortion k1 of -0.280 (± 0.004) where 0.000 is given", or "" unless Wrong(). It says "or more" ("or
  // less"), because a map that was made under the given lens holds the fit back.
  std::string Text() const;
  // Returns Text(), and what can be done about it.
  std::string Advice(FrameSource source) const;
};

// The lens that replaces the given one because the images ask for it.
struct RefinedLens {
  CameraModel camera;
  double focal_sigma_px = 0;     // one standard deviation; 0: the focal length is the given one
  bool center_is_found = false;  // else the principal point is the given one
  // Returns "a focal length of 521.4 px (± 0.6) and a distortion k1 of -0.052".
  std::string Text() const;
};
// Returns {focal_px, focal_sigma_px, cx, cy, k1, k2}; null without a lens.
nlohmann::ordered_json ToJson(const std::optional<RefinedLens>& lens);

// Checks the lens with index `lens` of an adjusted problem, whose intrinsics are `given`. Returns none with
// fewer than 5 cameras or 200 points of it. When `stop` is set, the fits end early and mean nothing.
std::optional<CalibrationCheck> CheckCalibration(const CameraModel& given, const BundleProblem& problem,
                                                 int lens = 0, const std::atomic<bool>* stop = nullptr);

// Returns {given_focal_px, fitted_focal_px, sigma_px, given_k1, fitted_k1, k1_sigma, given_center_px,
// fitted_center_px, center_sigma_px, error_share, determined, no_lens_fits, wrong}; null without a check.
nlohmann::ordered_json ToJson(const std::optional<CalibrationCheck>& check);

}  // namespace ulf::tracking
