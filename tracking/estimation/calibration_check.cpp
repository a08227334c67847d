#include "tracking/estimation/calibration_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/error.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::tracking {
namespace {

constexpr std::size_t kCheckMinCameras = 5, kCheckMinPoints = 200;  // fewer are too little evidence. Guessed
constexpr double kLeastDifference =
    0.015;                               // share of the focal length; smaller ones are not reported. Guessed
constexpr double kCheckFocalSigmas = 5;  // a difference of fewer may be chance. Guessed
// Distortion that moves the corner by a smaller share of its distance from the centre is not reported, nor
// what differs by fewer deviations. Guessed; handheld_kitchen's right lens, with a rolling shutter, has shown
// 0.022 in young maps.
constexpr double kLeastDistortion = 0.04, kDistortionSigmas = 10;
// A principal point that is nearer to the given one, in shares of the width, is not reported, nor one that is
// fewer deviations away: a turn of the camera looks much like it. Guessed.
constexpr double kLeastCenter = 0.02, kCenterSigmas = 10;
// Sigma's share of the focal length: above it that is undetermined. Guessed
constexpr double kMostUncertain = 0.005;

// True errors over what the centres move by: 1.1 to 1.5 in ten simulated runs with lenses that are 5 and 15 %
// off (seeds 21 to 24), 1.7 to 3.4 on handheld_kitchen.
constexpr double kHeldBack = 1.5;

}  // namespace

CalibrationCheck CalibrationCheck::Of(const CameraModel& resized) const {
  CalibrationCheck check = *this;
  const double scale = resized.MeanFocalPx() / given_focal_px;
  check.given_focal_px = resized.MeanFocalPx();
  check.fitted_focal_px *= scale;
  check.sigma_px *= scale;
  check.given_center_px *= scale;
  check.fitted_center_px *= scale;
  check.center_sigma_px *= scale;
  return check;
}

std::string CalibrationCheck::Advice(FrameSource source) const {
  const char* calibrate = IsTaken(source) ? "give their camera's calibration" : "calibrate";
  if (no_lens_fits)
    return Text() + ": it is far off, mostly too long; begin again with a shorter one, or " + calibrate;
  if (rows_uncompensated)
    return fmt::format(
        "{}; a rolling shutter can look like that, and the reverse: {}, then see which of the two is still "
        "reported",
        Text(), calibrate);
  return fmt::format("{}: {}, give {} refine, or run ulf refine --intrinsics afterwards", Text(), calibrate,
                     Parameter("intrinsics"));
}

std::string CalibrationCheck::Text() const {
  if (!Wrong()) return {};
  if (no_lens_fits)
    return fmt::format("images contradict the focal length of {:.1f} px, and no real lens near it fits them",
                       given_focal_px);
  const bool longer = fitted_focal_px > given_focal_px;
  const std::string focal = fmt::format(
      "a focal length of {:.1f} px (± {:.1f}) or {}, {:.1f} % {} the {:.1f} given", fitted_focal_px, sigma_px,
      longer ? "more" : "less", 100 * std::abs(fitted_focal_px / given_focal_px - 1),
      longer ? "above" : "below", given_focal_px);
  const std::string distortion = fmt::format("a distortion k1 of {:.3f} (± {:.3f}) where {:.3f} is given",
                                             fitted_k1, k1_sigma, given_k1);
  const std::string center = fmt::format(
      "a principal point of {:.0f}, {:.0f} (± {:.1f} px) where {:.0f}, {:.0f} is given", fitted_center_px.x(),
      fitted_center_px.y(), center_sigma_px, given_center_px.x(), given_center_px.y());
  std::vector<std::string> wrong;
  if (focal_wrong) wrong.push_back(focal);
  if (distortion_wrong) wrong.push_back(distortion);
  if (center_wrong) wrong.push_back(center);
  return fmt::format("images fit {}", fmt::join(wrong, ", and "));
}

nlohmann::ordered_json ToJson(const std::optional<CalibrationCheck>& check) {
  if (!check) return nullptr;
  return {{"given_focal_px", check->given_focal_px},
          {"fitted_focal_px", check->fitted_focal_px},
          {"sigma_px", check->sigma_px},
          {"given_k1", check->given_k1},
          {"fitted_k1", check->fitted_k1},
          {"k1_sigma", check->k1_sigma},
          {"given_center_px", {check->given_center_px.x(), check->given_center_px.y()}},
          {"fitted_center_px", {check->fitted_center_px.x(), check->fitted_center_px.y()}},
          {"center_sigma_px", check->center_sigma_px},
          {"error_share", check->error_share},
          {"determined", check->determined},
          {"no_lens_fits", check->no_lens_fits},
          {"wrong", check->Wrong()}};
}

std::string RefinedLens::Text() const {
  std::string text =
      focal_sigma_px > 0
          ? fmt::format("a focal length of {:.1f} px (± {:.1f})", camera.MeanFocalPx(), focal_sigma_px)
          : fmt::format("a focal length of {:.1f} px (as given)", camera.MeanFocalPx());
  if (camera.coefficients[0] != 0)
    text += fmt::format(" and a distortion k1 of {:.3f}", camera.coefficients[0]);
  if (center_is_found) text += fmt::format(" and a principal point of {:.0f}, {:.0f}", camera.cx, camera.cy);
  return text;
}

nlohmann::ordered_json ToJson(const std::optional<RefinedLens>& lens) {
  if (!lens) return nullptr;
  return {{"focal_px", lens->camera.MeanFocalPx()},
          {"focal_sigma_px", lens->focal_sigma_px},
          {"cx", lens->camera.cx},
          {"cy", lens->camera.cy},
          {"k1", lens->camera.coefficients[0]},
          {"k2", lens->camera.coefficients[1]}};
}

std::optional<CalibrationCheck> CheckCalibration(const CameraModel& given, const BundleProblem& problem,
                                                 int lens, const std::atomic<bool>* stop) {
  const LensEvidenceOptions fit_options{
      .max_cameras = 30, .max_points = 1000, .iterations = 30, .stop = stop};
  const BundleProblem part = PartForLens(problem, lens, fit_options);
  if (part.cam_from_world.size() < kCheckMinCameras || part.points.size() < kCheckMinPoints)
    return std::nullopt;
  const auto fits = FitLens(
      given, part,
      {{.focal = true}, {.focal = true, .k1 = true}, {.focal = true, .principal_point = true, .k1 = true}},
      fit_options);
  if (fits.size() < 2 || fits[0].free.k1 || fits[1].free.principal_point) return std::nullopt;
  // Take the fit that differs less from the given lens.
  const auto off = [&](const LensEstimate& fit) {
    return std::abs(fit.lens.MeanFocalPx() / given.MeanFocalPx() - 1);
  };
  const LensEstimate& fit = off(fits[0]) < off(fits[1]) ? fits[0] : fits[1];
  CalibrationCheck check;
  check.given_focal_px = given.MeanFocalPx();
  check.fitted_focal_px = fit.lens.MeanFocalPx();
  check.sigma_px = std::max(fits[0].focal_sigma_px, fits[1].focal_sigma_px);
  check.determined = check.sigma_px < kMostUncertain * check.given_focal_px;
  const bool same_side = (fits[0].lens.MeanFocalPx() > check.given_focal_px) ==
                         (fits[1].lens.MeanFocalPx() > check.given_focal_px);
  check.focal_wrong =
      check.determined && same_side && off(fit) > kLeastDifference &&
      std::abs(check.fitted_focal_px - check.given_focal_px) > kCheckFocalSigmas * check.sigma_px &&
      fits[0].gain > 0 && fits[1].gain > 0;
  const LensEstimate& bent = fits[1];
  check.given_k1 = given.coefficients[0];
  check.fitted_k1 = bent.lens.coefficients[0];
  check.k1_sigma = bent.k1_sigma;
  const double corner = std::hypot(given.width, given.height) / 2 / given.MeanFocalPx();
  const double difference = std::abs(check.fitted_k1 - check.given_k1);
  // A focal length that is left open may be so because of the distortion.
  check.distortion_wrong = difference * corner * corner > kLeastDistortion &&
                           difference > kDistortionSigmas * check.k1_sigma &&
                           bent.gain > std::max(0.0, fits[0].gain) + kStrongEvidence;
  // A focal length that is fitted without the distortion makes up for it.
  if (check.distortion_wrong) check.fitted_focal_px = bent.lens.MeanFocalPx();
  check.error_share = kHeldBack * (check.distortion_wrong ? bent : fit).centers_moved;
  check.given_center_px = check.fitted_center_px = {given.cx, given.cy};
  check.no_lens_fits =
      bent.gain > std::max(0.0, fits[0].gain) + kStrongEvidence && !IsPlausible(bent.lens, given);
  if (check.no_lens_fits) check.focal_wrong = check.distortion_wrong = false;
  if (fits.size() < 3 || check.no_lens_fits) return check;
  const LensEstimate& moved = fits[2];
  check.fitted_center_px = {moved.lens.cx, moved.lens.cy};
  check.center_sigma_px = moved.principal_point_sigma_px;
  const double shift_px = (check.fitted_center_px - check.given_center_px).norm();
  check.center_wrong = shift_px > kLeastCenter * given.width &&
                       shift_px > kCenterSigmas * check.center_sigma_px &&
                       moved.gain > std::max({0.0, fits[0].gain, bent.gain}) + kStrongEvidence;
  if (!check.center_wrong) return check;
  // What was fitted with the given principal point makes up for it.
  check.error_share = kHeldBack * moved.centers_moved;
  check.fitted_focal_px = moved.lens.MeanFocalPx();
  check.focal_wrong = check.focal_wrong && off(moved) > kLeastDifference;
  check.fitted_k1 = moved.lens.coefficients[0];
  check.distortion_wrong = check.distortion_wrong &&
                           std::abs(check.fitted_k1 - check.given_k1) * corner * corner > kLeastDistortion;
  return check;
}

}  // namespace ulf::tracking
