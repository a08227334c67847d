// Checks whether the images contradict the given lens: its focal length, the first coefficient of its
// distortion, and its principal point.
//
// A wrong lens bends the whole world and leaves residuals that look like noise. The check frees the focal
// length in an adjustment, and reports it when the result differs by a share that matters and by many
// standard deviations, with distortion held and with distortion free; in the latter it judges the distortion
// as well, and with the principal point free that. Flat scenes and sideways motion leave the lens
// undetermined; then its standard deviation is large and nothing is reported.
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
  double sigma_px = 0;      // one standard deviation of the fitted one
  bool determined = false;  // the geometry determines it
  double given_k1 = 0, fitted_k1 = 0, k1_sigma = 0;
  Eigen::Vector2d given_center_px = Eigen::Vector2d::Zero(), fitted_center_px = Eigen::Vector2d::Zero();
  double center_sigma_px = 0;
  bool focal_wrong = false, distortion_wrong = false, center_wrong = false;
  // No plausible lens fits the images (IsPlausible()); then no value is reported.
  bool no_lens_fits = false;
  bool Wrong() const { return focal_wrong || distortion_wrong || center_wrong || no_lens_fits; }
  // The error of the cameras' centres as a share of the distance of what they see: 1.5 times how far they
  // move when the lens is freed, because a map that was made under the given lens holds them back.
  double error_share = 0;
  // A rolling shutter was found and not compensated: it stretches images as another focal length does, and
  // the other way round.
  bool rows_uncompensated = false;

  // Converts the check to a camera whose images are the given ones, resized.
  CalibrationCheck Of(const CameraModel& resized) const;
  // "images fit a focal length of 551.2 px (± 1.3) or more, 5.0 % above the 525.0 given", "images fit a
  // distortion k1 of -0.280 (± 0.004) where 0.000 is given"; empty unless wrong. "or more", because a map
  // that was made under the given lens holds the fit back.
  std::string Text() const;
  // Returns Text() and what can be done about it.
  std::string Advice(FrameSource source) const;
};

// The lens that images ask for in place of the given one.
struct RefinedLens {
  CameraModel camera;
  double focal_sigma_px = 0;     // one standard deviation; 0: the focal length is the given one
  bool center_is_found = false;  // else the principal point is the given one
  // "a focal length of 521.4 px (± 0.6) and a distortion k1 of -0.052"
  std::string Text() const;
};
// {focal_px, focal_sigma_px, cx, cy, k1, k2}; null where the given lens stayed.
nlohmann::ordered_json ToJson(const std::optional<RefinedLens>& lens);

// Checks the given lens of an adjusted problem. Returns none where there is too little evidence. `stop`: when
// set, the fits end early and mean nothing.
std::optional<CalibrationCheck> CheckCalibration(const CameraModel& given, const BundleProblem& problem,
                                                 int lens = 0, const std::atomic<bool>* stop = nullptr);

// {given_focal_px, fitted_focal_px, sigma_px, given_k1, fitted_k1, k1_sigma, given_center_px,
// fitted_center_px, center_sigma_px, error_share, determined, no_lens_fits, wrong}; null without a check.
nlohmann::ordered_json ToJson(const std::optional<CalibrationCheck>& check);

}  // namespace ulf::tracking
