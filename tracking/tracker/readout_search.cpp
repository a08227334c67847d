#include "tracking/tracker/readout_search.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

namespace ulf::tracking {

ReadoutSearch::ReadoutSearch(RowMotion& rows, Mapper& mapper, ReadoutUse use,
                             const ReadoutSearchOptions& options)
    : rows_(rows), mapper_(mapper), use_(use), options_(options) {
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
  if (!last_) return options_.usual_readout_s;
  const double size_s = std::abs(last_->readout_s);
  return size_s > std::max(options_.least_readout_s, options_.suspected_sigmas * last_->sigma_s) ? size_s : 0;
}

void ReadoutSearch::Judge(const ReadoutEstimate& estimate, bool lens_is_doubted) {
  last_ = estimate;
  const double now_s = rows_.readout_s(), size_s = std::abs(estimate.readout_s);
  spdlog::debug("readout {:.2f} +- {:.2f} ms from {} keyframes, {:.2f} so far", 1e3 * estimate.readout_s,
                1e3 * estimate.sigma_s, estimate.keyframes, 1e3 * now_s);
  const bool enough = estimate.keyframes >= options_.enough_keyframes;
  const bool may_be_the_lens = lens_is_doubted || estimate.keyframes < options_.early_keyframes;
  const double needed = may_be_the_lens ? options_.doubted_sigmas : options_.certain_sigmas;
  if (use_ == ReadoutUse::kGiven) return JudgeGiven(estimate, needed);
  if (size_s < options_.least_readout_s || size_s < needed * estimate.sigma_s) {
    certain_ = 0;
    const bool none = size_s + options_.certain_sigmas * estimate.sigma_s < options_.least_readout_s;
    if (!none && !enough) return;
    if (now_s != 0) Apply(0);
    found_.reset();
    last_ = ReadoutEstimate{};  // decided: nothing is suspected any more
    return End();
  }
  if (++certain_ < options_.times_certain) return;
  const bool first_report = !found_;
  const bool compensate = use_ == ReadoutUse::kCompensate;
  found_ = Readout{estimate.readout_s, estimate.sigma_s, compensate};
  if (first_report) spdlog::info("{}", found_->InWords());
  const double change_s = std::abs(estimate.readout_s - now_s);
  if (!compensate ||
      (now_s != 0 && change_s < std::max(estimate.sigma_s, options_.settled_share * std::abs(now_s)))) {
    if (compensate) found_->readout_s = now_s;
    if (estimate.sigma_s < options_.settled_share * size_s || enough) End();
    return;
  }
  Apply(estimate.readout_s);
  if (++applied_ == options_.most_changes) End();
}

void ReadoutSearch::JudgeGiven(const ReadoutEstimate& estimate, double needed_sigmas) {
  const double given_s = rows_.readout_s(), off_s = std::abs(estimate.readout_s - given_s);
  const bool wrong =
      off_s > std::max({options_.least_wrong_s, options_.least_wrong_share * std::abs(estimate.readout_s),
                        needed_sigmas * estimate.sigma_s});
  certain_ = wrong ? certain_ + 1 : 0;
  const bool was_contradicted = found_ && found_->contradicted;
  found_.reset();
  if (rows_.rolls()) found_ = Readout{given_s};
  if (certain_ < options_.times_certain) return;
  found_ = Readout{given_s, {}, rows_.rolls(), Readout::Contradiction{estimate.readout_s, estimate.sigma_s}};
  if (!was_contradicted) spdlog::warn("{}", found_->InWords());
}

void ReadoutSearch::Apply(double readout_s) {
  mapper_.Rest();
  rows_.SetReadout(readout_s);
  mapper_.SetReadout(readout_s);
}

}  // namespace ulf::tracking
