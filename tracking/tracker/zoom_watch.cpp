#include "tracking/tracker/zoom_watch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/at.h"
#include "core/base/quantile.h"

namespace ulf::tracking {

void ZoomWatch::Forget() {
  before_.clear();
  log_ratio_ = 0;
  since_disagreed_ = kLongAgo;
}

// Frames follow one another quickly: what is left of the difference shows in the next.
void ZoomWatch::Follow(double difference, double noise) {
  if (std::abs(difference) > noise) log_ratio_ += difference;
  if (std::abs(log_ratio_) >= options_.back) return;
  log_ratio_ = 0;
  since_disagreed_ = kLongAgo;
}

void ZoomWatch::Step(double time_s, const std::optional<FocalChange>& change, double other) {
  ++since_disagreed_;
  if (!change) return;
  const double doubt = std::max(1.0, change->sigma / options_.uncertain);
  const double noise = std::hypot(options_.sigmas * doubt * change->sigma, options_.other_sigmas * other);
  if (IsMoved() && doubt > 2) return;
  if (IsMoved()) return Follow(change->log_ratio - usual_, options_.followed_sigmas * change->sigma);
  before_.push_back({time_s, change->log_ratio});
  while (before_.size() > options_.last_frames + options_.fewest_before &&
         before_.front().time_s < time_s - options_.before_s)
    before_.pop_front();
  if (before_.size() < options_.last_frames + options_.fewest_before) return;
  const auto first_of_last = before_.end() - static_cast<std::ptrdiff_t>(options_.last_frames);
  std::vector<double> of_before, sizes_before, of_last;
  for (auto frame = before_.begin(); frame != before_.end(); ++frame) {
    const bool last = frame >= first_of_last;
    (last ? of_last : of_before).push_back(frame->log_ratio);
    if (!last) sizes_before.push_back(std::abs(frame->log_ratio));
  }
  const double usual = Median(std::move(of_before)), size = Median(std::move(sizes_before));
  const bool disagrees = std::abs(change->log_ratio - usual) >
                         std::max({options_.suspicious, options_.suspicious_times * size, noise});
  if (disagrees) since_disagreed_ = 0;
  const double moved = Median(std::move(of_last)) - usual;
  if (std::abs(moved) < std::max({options_.moved, options_.moved_times * size, noise})) return;
  usual_ = usual;
  before_.erase(first_of_last, before_.end());
  Follow(change->log_ratio - usual_, 0);
}

}  // namespace ulf::tracking
