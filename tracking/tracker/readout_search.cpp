#include "tracking/tracker/readout_search.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

namespace ulf::tracking {

namespace {

constexpr double kReadoutCertainSigmas = 6;  // a smaller readout may be chance. Guessed
// The same where a wrong lens may look like rows: of so few keyframes, or once images contradict the lens. Up
// to 11 deviations were seen of a focal length that was 15 % off, 12 and more of rolling shutters.
constexpr double kReadoutDoubtedSigmas = 12;
constexpr int kReadoutEarlyKeyframes = 8;
// A measured readout of so many deviations is reckoned with until it is decided, and this one before the
// first measurement: a phone or a webcam takes 10 to 33 ms. Guessed.
constexpr double kReadoutSuspectedSigmas = 3, kReadoutUsualReadoutS = 0.02;
// A shorter readout moves hardly anything by a tenth of a pixel
constexpr double kReadoutLeastReadoutS = 0.002;
// A given readout that is off by less, or by less than this share of what images tell, is not contradicted: a
// map that was made under it holds the measured one back. Guessed.
constexpr double kReadoutLeastWrongS = 0.005, kReadoutLeastWrongShare = 0.3;
constexpr int kReadoutTimesCertain = 2;  // measurements in a row before the tracker reports it. Guessed
constexpr int kReadoutMostChanges = 6;   // applied readouts, then the search ends. Guessed
// After so many the tracker decides that the shutter is global. Guessed
constexpr int kReadoutEnoughKeyframes = 24;

}  // namespace

ReadoutSearch::ReadoutSearch(RowMotion& rows, Mapper& mapper, ReadoutUse use)
    : rows_(rows), mapper_(mapper), use_(use) {
  mapper_.MeasureReadout(true);
  if (use_ == ReadoutUse::kGiven && rows_.rolls()) found_ = Readout{rows_.readout_s()};
}

void ReadoutSearch::Restart() {
  certain_ = applied_ = 0;
  last_.reset();
  judged_ = mapper_.shared().readouts_measured;  // those were under the lens before
  mapper_.MeasureReadout(true);
}

void ReadoutSearch::Step() {
  const SharedMap& shared = mapper_.shared();
  if (shared.readouts_measured == judged_) return;
  std::optional<ReadoutEstimate> estimate;
  bool lens_is_doubted;
  {
    const MapLock lock(shared);
    judged_ = shared.readouts_measured;
    estimate = shared.readout;
    lens_is_doubted = shared.wrong_lens.has_value();
  }
  if (estimate) Judge(*estimate, lens_is_doubted);
}

double ReadoutSearch::Suspected() const {
  if (use_ == ReadoutUse::kGiven)
    return found_ && found_->contradicted ? std::abs(found_->contradicted->readout_s - rows_.readout_s()) : 0;
  if (rows_.rolls()) return 0;
  if (!last_) return kReadoutUsualReadoutS;
  const double size_s = std::abs(last_->readout_s);
  return size_s > std::max(kReadoutLeastReadoutS, kReadoutSuspectedSigmas * last_->sigma_s) ? size_s : 0;
}

void ReadoutSearch::Judge(const ReadoutEstimate& estimate, bool lens_is_doubted) {
  last_ = estimate;
  const double now_s = rows_.readout_s(), size_s = std::abs(estimate.readout_s);
  spdlog::debug("readout {:.2f} +- {:.2f} ms from {} keyframes, {:.2f} so far", 1e3 * estimate.readout_s,
                1e3 * estimate.sigma_s, estimate.keyframes, 1e3 * now_s);
  const bool enough = estimate.keyframes >= kReadoutEnoughKeyframes;
  const bool may_be_the_lens = lens_is_doubted || estimate.keyframes < kReadoutEarlyKeyframes;
  const double needed = may_be_the_lens ? kReadoutDoubtedSigmas : kReadoutCertainSigmas;
  if (use_ == ReadoutUse::kGiven) return JudgeGiven(estimate, needed);
  if (size_s < kReadoutLeastReadoutS || size_s < needed * estimate.sigma_s) {
    certain_ = 0;
    const bool none = size_s + kReadoutCertainSigmas * estimate.sigma_s < kReadoutLeastReadoutS;
    if (!none && !enough) return;
    if (now_s != 0) Apply(0);
    found_.reset();
    last_ = ReadoutEstimate{};  // decided: nothing is suspected any more
    return End();
  }
  if (++certain_ < kReadoutTimesCertain) return;
  const bool first_report = !found_;
  const bool compensate = use_ == ReadoutUse::kCompensate;
  found_ = Readout{estimate.readout_s, estimate.sigma_s, compensate};
  if (first_report) spdlog::info("{}", found_->InWords());
  const double change_s = std::abs(estimate.readout_s - now_s);
  if (!compensate ||
      (now_s != 0 && change_s < std::max(estimate.sigma_s, kSettledReadoutShare * std::abs(now_s)))) {
    if (compensate) found_->readout_s = now_s;
    if (estimate.sigma_s < kSettledReadoutShare * size_s || enough) End();
    return;
  }
  Apply(estimate.readout_s);
  if (++applied_ == kReadoutMostChanges) End();
}

void ReadoutSearch::JudgeGiven(const ReadoutEstimate& estimate, double needed_sigmas) {
  const double given_s = rows_.readout_s(), off_s = std::abs(estimate.readout_s - given_s);
  const bool wrong =
      off_s > std::max({kReadoutLeastWrongS, kReadoutLeastWrongShare * std::abs(estimate.readout_s),
                        needed_sigmas * estimate.sigma_s});
  certain_ = wrong ? certain_ + 1 : 0;
  const bool was_contradicted = found_ && found_->contradicted;
  found_.reset();
  if (rows_.rolls()) found_ = Readout{given_s};
  if (certain_ < kReadoutTimesCertain) return;
  found_ = Readout{given_s, {}, rows_.rolls(), Readout::Contradiction{estimate.readout_s, estimate.sigma_s}};
  if (!was_contradicted) spdlog::warn("{}", found_->InWords());
}

void ReadoutSearch::Apply(double readout_s) {
  mapper_.WaitUntilIdle();
  rows_.SetReadout(readout_s);
  mapper_.SetReadout(readout_s);
}

}  // namespace ulf::tracking
