#include "coverage/session/watch/focus_watch.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

// Settled on simulated scenes (docs/capture.md#mistakes).
constexpr std::size_t kFocusFewest = 20;  // points of a pair of pictures; fewer say nothing
constexpr double kFocusSharpestOf_s = 0.4;
constexpr double kFocusLeastSwing = 0.25;  // logarithm of fine detail (amplitude); smaller ones do not count
constexpr int kFocusSwings = 4;            // there and back, twice
constexpr double kFocusWithin_s = 8;

}  // namespace

void FocusWatch::Update(const PicturePair& pair) {
  if (pair.tracks.size() < kFocusFewest || (!moments_.empty() && moments_.back().time_s != pair.before_s)) {
    moments_.clear();
    swings_.clear();
    direction_ = 0;
    if (pair.tracks.size() < kFocusFewest) return;
  }
  // Those with the most detail in both pictures: others are noise. Energy is the square of an amplitude.
  std::vector<PictureTrack> tracks = pair.tracks;
  std::ranges::sort(tracks, std::greater{}, &PictureTrack::detail);
  std::vector<double> changes;
  for (std::size_t i = 0; i < tracks.size() / 2; ++i) changes.push_back(0.5 * tracks[i].log_detail);
  const bool begins = moments_.empty();
  if (begins) moments_.push_back({pair.before_s, 0});
  moments_.push_back({pair.now_s, moments_.back().log_detail + Median(std::move(changes))});
  while (pair.now_s - moments_.front().time_s > kFocusSharpestOf_s) moments_.pop_front();
  const double sharpest = std::ranges::max(moments_, {}, &Moment::log_detail).log_detail;
  if (begins) highest_ = lowest_ = sharpest;
  highest_ = std::max(highest_, sharpest);
  lowest_ = std::min(lowest_, sharpest);
  const bool falls = direction_ >= 0 && highest_ - sharpest >= kFocusLeastSwing,
             rises = direction_ <= 0 && sharpest - lowest_ >= kFocusLeastSwing;
  if (falls || rises) {
    direction_ = falls ? -1 : 1;
    swings_.push_back({pair.now_s, falls ? highest_ : lowest_});
    highest_ = lowest_ = sharpest;
  }
  while (!swings_.empty() && pair.now_s - swings_.front().time_s > kFocusWithin_s) swings_.pop_front();
  if (static_cast<int>(swings_.size()) < kFocusSwings) return;
  const auto [low, high] = std::ranges::minmax(swings_, {}, &Moment::log_detail);
  last_swing_s_ = swings_.back().time_s;
  hunts_ = std::max(hunts_.value_or(1), std::exp(high.log_detail - low.log_detail));
}

}  // namespace ulf::coverage
