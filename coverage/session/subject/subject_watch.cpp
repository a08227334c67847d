#include "coverage/session/subject/subject_watch.h"

namespace ulf::coverage {
void SubjectWatch::Reset() {
  frames_.clear();
  gone_since_s_.reset();
  frames_gone_ = 0;
}

std::optional<double> SubjectWatch::ShareFound() const {
  Tally sum;
  for (const Tally& frame : frames_) {
    sum.expected_on += frame.expected_on, sum.found_on += frame.found_on;
    sum.expected_off += frame.expected_off, sum.found_off += frame.found_off;
  }
  const double fewest = options_.fewest_per_frame * static_cast<double>(frames_.size());
  if (frames_.size() < options_.fewest_frames || sum.expected_on < fewest || sum.expected_off < fewest)
    return std::nullopt;
  const double on = sum.found_on / sum.expected_on, off = sum.found_off / sum.expected_off;
  return off < options_.rest_share ? std::nullopt : std::optional(on / off);
}

bool SubjectWatch::Moved(double time_s, std::span<const tracking::ExpectedPoint> points,
                         const Subject& subject) {
  if (gone_since_s_) ++frames_gone_;
  Tally now{.time_s = time_s};
  for (const tracking::ExpectedPoint& point : points) {
    if (point.times_expected < options_.known_for_frames + frames_gone_) continue;
    const bool on = (point.position_in_world - subject.center_in_world).norm() <= subject.radius;
    (on ? now.expected_on : now.expected_off) += point.find_rate;
    (on ? now.found_on : now.found_off) += point.found;
  }
  while (!frames_.empty() &&
         (time_s - frames_.front().time_s > options_.over_s || time_s < frames_.front().time_s))
    frames_.pop_front();
  frames_.push_back(now);
  if (const auto share = ShareFound()) {
    if (*share < options_.gone_share && !gone_since_s_) gone_since_s_ = time_s;
    if (*share > options_.there_share) gone_since_s_.reset(), frames_gone_ = 0;
  }
  return gone_since_s_ && time_s - *gone_since_s_ >= options_.stays_gone_s;
}

}  // namespace ulf::coverage
