#include "tracking/map/lens_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ulf::tracking {

bool LensWatch::Agree(const CalibrationCheck& earlier, const CalibrationCheck& later) const {
  if (later.no_lens_fits) return earlier.no_lens_fits;
  if (later.focal_wrong && earlier.focal_wrong)
    return std::abs(later.fitted_focal_px - earlier.fitted_focal_px) <
           options_.most_apart * later.given_focal_px;
  if (later.distortion_wrong && earlier.distortion_wrong)
    return std::abs(later.fitted_k1 - earlier.fitted_k1) <
           options_.most_apart_k1 * std::abs(later.fitted_k1 - later.given_k1);
  return later.center_wrong && earlier.center_wrong &&
         (later.fitted_center_px - earlier.fitted_center_px).norm() <
             options_.most_apart_center * later.given_focal_px;
}

void LensWatch::Note(const std::optional<CalibrationCheck>& check, int keyframes) {
  next_ = std::max(keyframes + 1, static_cast<int>(std::lround(keyframes * options_.growth)));
  const bool agree = check && before_ && Agree(*before_, *check);
  if (agree)
    contradiction_ = check;
  else if (!check || !check->Wrong())
    contradiction_.reset();
  before_ = check;
}

void LensWatch::NoteDoubted(const CalibrationCheck& check, int keyframes) {
  Note(check, keyframes);
  contradiction_ = check;
}

void LensWatch::Restart(int keyframes) {
  before_.reset();
  Note(std::nullopt, keyframes);
}

void LensWatch::NoteSought(int keyframes, double focal_px_before, double focal_px) {
  const bool settled =
      keyframes >= options_.sought_keyframes && std::abs(focal_px / focal_px_before - 1) < options_.settled;
  sought_at_ = settled ? std::numeric_limits<int>::max()
                       : std::max(options_.sought_keyframes,
                                  static_cast<int>(std::lround(keyframes * options_.sought_growth)));
}

void LensWatch::Reset() {
  next_ = options_.first_keyframes;
  sought_at_ = options_.sought_keyframes;
  before_.reset();
  contradiction_.reset();
}

}  // namespace ulf::tracking
