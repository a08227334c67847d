#include "coverage/subject_watch.h"

namespace ulf {
namespace {

constexpr double kOver_s = 0.7;
// A point has to be known for so many frames: what a subject that has moved shows soon becomes points of its
// own, found every time, which would speak for it.
constexpr int kKnownFor = 20;
// Of what their record promises, the subject's points against the others: below this it has moved.
constexpr double kMoved = 0.45;
// Fewer say nothing: of the points that should have been found in that second, per frame and in all.
constexpr double kFewestPerFrame = 8;
constexpr std::size_t kFewestFrames = 5;
// Where most of the rest is not found either, it is the tracker that is in trouble.
constexpr double kRestHolds = 0.5;

}  // namespace

bool SubjectWatch::Moved(double time_s, std::span<const ExpectedPoint> points, const Subject& subject) {
  Tally now{.time_s = time_s};
  for (const ExpectedPoint& point : points) {
    if (point.times_expected < kKnownFor) continue;
    const bool on = (point.position_in_world - subject.center_in_world).norm() <= subject.radius;
    (on ? now.expected_on : now.expected_off) += point.find_rate;
    (on ? now.found_on : now.found_off) += point.found;
  }
  while (!frames_.empty() && (time_s - frames_.front().time_s > kOver_s || time_s < frames_.front().time_s))
    frames_.pop_front();
  frames_.push_back(now);
  Tally sum;
  for (const Tally& frame : frames_) {
    sum.expected_on += frame.expected_on, sum.found_on += frame.found_on;
    sum.expected_off += frame.expected_off, sum.found_off += frame.found_off;
  }
  const double fewest = kFewestPerFrame * static_cast<double>(frames_.size());
  if (frames_.size() < kFewestFrames || sum.expected_on < fewest || sum.expected_off < fewest) return moved_;
  const double on = sum.found_on / sum.expected_on, off = sum.found_off / sum.expected_off;
  if (off < kRestHolds) return moved_;
  if (on < kMoved * off) moved_ = true;
  return moved_;
}

}  // namespace ulf
