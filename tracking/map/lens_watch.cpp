#include "tracking/map/lens_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ulf::tracking {

namespace {

// The lens is checked when the map has so many keyframes, and again each time it has grown by this factor.
// Guessed.
constexpr int kFirstLensCheck = 8;
constexpr double kLensCheckGrowth = 1.25;
// Two checks agree whose focal lengths differ by a smaller share, or whose distortions by a smaller share of
// the difference from the given one, or whose principal points by a smaller share of the focal length.
// Guessed.
constexpr double kLensMostApart = 0.02, kLensMostApartK1 = 0.3, kLensMostApartCenter = 0.01;
// A lens that nobody has calibrated is sought when the map has so many keyframes, again each time it has
// grown by this, and no longer once its focal length has changed by less than this share. Guessed.
constexpr int kLensSoughtKeyframes = 20;
constexpr double kLensSoughtGrowth = 1.6;
constexpr double kLensSettled = 0.005;

}  // namespace

bool LensWatch::Agree(const CalibrationCheck& earlier, const CalibrationCheck& later) const {
  if (later.no_lens_fits) return earlier.no_lens_fits;
  if (later.focal_wrong && earlier.focal_wrong)
    return std::abs(later.fitted_focal_px - earlier.fitted_focal_px) < kLensMostApart * later.given_focal_px;
  if (later.distortion_wrong && earlier.distortion_wrong)
    return std::abs(later.fitted_k1 - earlier.fitted_k1) <
           kLensMostApartK1 * std::abs(later.fitted_k1 - later.given_k1);
  return later.center_wrong && earlier.center_wrong &&
         (later.fitted_center_px - earlier.fitted_center_px).norm() <
             kLensMostApartCenter * later.given_focal_px;
}

void LensWatch::Note(const std::optional<CalibrationCheck>& check, int keyframes) {
  next_ = std::max(keyframes + 1, static_cast<int>(std::lround(keyframes * kLensCheckGrowth)));
  const bool agree = check && before_ && Agree(*before_, *check);
  if (agree)
    contradiction_ = check;
  else if (!check || !check->Wrong())
    contradiction_.reset();
  before_ = check;
}

void LensWatch::AddConfirmed(const CalibrationCheck& check, int keyframes) {
  Note(check, keyframes);
  contradiction_ = check;
}

void LensWatch::Restart(int keyframes) {
  before_.reset();
  Note(std::nullopt, keyframes);
}

void LensWatch::SearchDone(int keyframes, double focal_px_before, double focal_px) {
  const bool settled =
      keyframes >= kLensSoughtKeyframes && std::abs(focal_px / focal_px_before - 1) < kLensSettled;
  sought_at_ =
      settled ? std::numeric_limits<int>::max()
              : std::max(kLensSoughtKeyframes, static_cast<int>(std::lround(keyframes * kLensSoughtGrowth)));
}

void LensWatch::Reset() {
  next_ = kFirstLensCheck;
  sought_at_ = kLensSoughtKeyframes;
  before_.reset();
  contradiction_.reset();
}

}  // namespace ulf::tracking
