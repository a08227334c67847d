#include "tracking/tracker/zoom_watch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/quantile.h"

namespace ulf::tracking {

namespace {

// Logarithms of the focal length: 0.01 is 1 %. Measured on recordings and simulated scenes with right lenses,
// with lenses 5 and 15 % off, and with rolling shutters that turn fast (docs/measured/tracking.md, "A zoom
// that is moved"). A frame that differs by more is no keyframe, nor are those that follow it closely; by so
// many times the size of the differences before, where a map disagrees all the time.
constexpr double kZoomSuspicious = 0.006, kZoomSuspiciousTimes = 2.5;
// The zoom is moved where the last frames differ by more in the median.
constexpr double kZoomMoved = 0.01, kZoomMovedTimes = 4;
constexpr double kZoomBack = 0.005;  // it is back where the focal length followed differs by less
// A smaller difference may be chance, or what neighbouring points and the map are off by together; of a moved
// zoom, once it is known, chance alone counts.
constexpr double kZoomSigmas = 10, kZoomOtherSigmas = 5, kZoomFollowedSigmas = 2;
// A frame whose own deviation is larger, before a wall for example, counts less by as much.
constexpr double kZoomUncertain = 0.0015;
// The last frames are compared with the median of the frames of so long before them, and at least so many.
constexpr double kZoomBeforeS = 2;
constexpr std::size_t kZoomFewestBefore = 15;

}  // namespace

void ZoomWatch::Forget() {
  before_.clear();
  log_ratio_ = 0;
  since_disagreed_ = kLongAgo;
}

// Frames follow one another quickly: what is left of the difference shows in the next.
void ZoomWatch::Follow(double difference, double noise) {
  if (std::abs(difference) > noise) log_ratio_ += difference;
  if (std::abs(log_ratio_) >= kZoomBack) return;
  log_ratio_ = 0;
  since_disagreed_ = kLongAgo;
}

void ZoomWatch::Step(double time_s, const std::optional<FocalChange>& change, double other) {
  ++since_disagreed_;
  if (!change) return;
  const double doubt = std::max(1.0, change->sigma / kZoomUncertain);
  const double noise = std::hypot(kZoomSigmas * doubt * change->sigma, kZoomOtherSigmas * other);
  if (IsMoved() && doubt > 2) return;
  if (IsMoved()) return Follow(change->log_ratio - usual_, kZoomFollowedSigmas * change->sigma);
  before_.push_back({time_s, change->log_ratio});
  while (before_.size() > kLastFrames + kZoomFewestBefore && before_.front().time_s < time_s - kZoomBeforeS)
    before_.pop_front();
  if (before_.size() < kLastFrames + kZoomFewestBefore) return;
  const auto first_of_last = before_.end() - static_cast<std::ptrdiff_t>(kLastFrames);
  std::vector<double> of_before, sizes_before, of_last;
  for (auto frame = before_.begin(); frame != before_.end(); ++frame) {
    const bool last = frame >= first_of_last;
    (last ? of_last : of_before).push_back(frame->log_ratio);
    if (!last) sizes_before.push_back(std::abs(frame->log_ratio));
  }
  const double usual = Median(std::move(of_before)), size = Median(std::move(sizes_before));
  const bool disagrees =
      std::abs(change->log_ratio - usual) > std::max({kZoomSuspicious, kZoomSuspiciousTimes * size, noise});
  if (disagrees) since_disagreed_ = 0;
  const double moved = Median(std::move(of_last)) - usual;
  if (std::abs(moved) < std::max({kZoomMoved, kZoomMovedTimes * size, noise})) return;
  usual_ = usual;
  before_.erase(first_of_last, before_.end());
  Follow(change->log_ratio - usual_, 0);
}

}  // namespace ulf::tracking
