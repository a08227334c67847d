// The part of the mapper that asks the map about the lens under which it is made.
#include <cmath>

#include "tracking/estimation/calibration_check.h"
#include "tracking/estimation/lens_evidence.h"
#include "tracking/map/loop_closer.h"
#include "tracking/map/map_adjustment.h"
#include "tracking/map/mapper.h"

namespace ulf::tracking {

namespace {

constexpr AdjustmentEffort kAdjustmentWithLens = {40, 40};  // of a map whose lens was wrong

}  // namespace

void Mapper::CheckLens() {
  const int keyframes = map_.LivingKeyframes();
  if (!options_.check_lens || !lens_.IsDue(keyframes)) return;
  const auto check = CheckCalibration(camera_, ProblemOf(map_), 0, &cut_short_);
  if (cut_short_) return;
  lens_.Note(check, keyframes);
  if (options_.seek_lens && lens_.IsSearchDue(keyframes)) owned_.shared.lens_is_due = true;
  const MapLock lock(owned_.shared);
  owned_.shared.wrong_lens = lens_.contradiction();
}

bool Mapper::ContradictsLensBeyond(double log_ratio) {
  if (!options_.check_lens) return false;
  const auto check = CheckCalibration(camera_, ProblemOf(map_));
  if (!check || !(check->focal_wrong || check->no_lens_fits)) return false;
  // Keyframes that were taken before the zoom was noticed bend the map its way, and by less.
  constexpr double kMost = 2;  // guessed
  const double off = std::log(check->fitted_focal_px / check->given_focal_px);
  if (!check->no_lens_fits && off * log_ratio > 0 && std::abs(off) < kMost * std::abs(log_ratio))
    return false;
  lens_.AddConfirmed(*check, map_.LivingKeyframes());
  const MapLock lock(owned_.shared);
  owned_.shared.wrong_lens = lens_.contradiction();
  return true;
}

std::optional<RefinedLens> Mapper::RefineLens() {
  cut_short_ = false;
  {
    const MapLock lock(owned_.shared);
    owned_.shared.wrong_lens.reset();
  }
  owned_.shared.lens_is_due = false;
  const int keyframes = map_.LivingKeyframes();
  lens_.Restart(keyframes);
  const auto chosen = ChooseLens(camera_, PartForLens(ProblemOf(map_), 0));
  lens_.SearchDone(keyframes, camera_.MeanFocalPx(), (chosen ? chosen->lens : camera_).MeanFocalPx());
  if (!chosen) return std::nullopt;
  BundleOptions options = BundleOptionsFor(kAdjustmentWithLens);
  options.free = chosen->free;
  CameraModel lens = camera_;
  if (!AdjustMapAndLens(lens, owned_, options).usable) return std::nullopt;
  camera_ = lens;
  loops_->SetCamera(lens);
  const MapLock lock(owned_.shared);
  owned_.map.SetCamera(lens);
  ++owned_.shared.revision;
  return RefinedLens{lens, chosen->focal_sigma_px, chosen->free.principal_point};
}

}  // namespace ulf::tracking
