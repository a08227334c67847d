#include "coverage/session/subject/subject_watch.h"

namespace ulf::coverage {
namespace {

constexpr double kOver_s = 0.3;
// Of what their record promises, the subject's points against the others: gone below, there again above.
constexpr double kGone = 0.45, kThere = 0.8;
// So long they have to be gone: a hand passes before the subject.
constexpr double kStaysGone_s = 0.5;
// A point has to be known for so many frames, and since before they were gone: what a subject that has moved
// shows soon becomes points of its own, which would speak for it.
constexpr int kKnownFor = 20;
// Fewer say nothing: of the points that should have been found, per frame.
constexpr double kFewestPerFrame = 8;
constexpr std::size_t kFewestFrames = 3;
// Where most of the rest is not found either, it is the tracker that is in trouble.
constexpr double kRestHolds = 0.5;

}  // namespace

void SubjectWatch::Forget() {
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
  const double fewest = kFewestPerFrame * static_cast<double>(frames_.size());
  if (frames_.size() < kFewestFrames || sum.expected_on < fewest || sum.expected_off < fewest)
    return std::nullopt;
  const double on = sum.found_on / sum.expected_on, off = sum.found_off / sum.expected_off;
  return off < kRestHolds ? std::nullopt : std::optional(on / off);
}

bool SubjectWatch::Moved(double time_s, std::span<const tracking::ExpectedPoint> points,
                         const Subject& subject) {
  if (gone_since_s_) ++frames_gone_;
  Tally now{.time_s = time_s};
  for (const tracking::ExpectedPoint& point : points) {
    if (point.times_expected < kKnownFor + frames_gone_) continue;
    const bool on = (point.position_in_world - subject.center_in_world).norm() <= subject.radius;
    (on ? now.expected_on : now.expected_off) += point.find_rate;
    (on ? now.found_on : now.found_off) += point.found;
  }
  while (!frames_.empty() && (time_s - frames_.front().time_s > kOver_s || time_s < frames_.front().time_s))
    frames_.pop_front();
  frames_.push_back(now);
  if (const auto share = ShareFound()) {
    if (*share < kGone && !gone_since_s_) gone_since_s_ = time_s;
    if (*share > kThere) gone_since_s_.reset(), frames_gone_ = 0;
  }
  return gone_since_s_ && time_s - *gone_since_s_ >= kStaysGone_s;
}

}  // namespace ulf::coverage
