#include "coverage/session/capture_subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/counted.h"
#include "coverage/bound/sphere_outline.h"

namespace ulf::coverage {
namespace {

// In radii: a corrected map moves the sphere when it would move or grow by more than the first; more than the
// second is reported. Guessed.
constexpr double kSubjectWorthFollowing = 0.01, kSubjectWorthTelling = 0.05;
// Before the first view it is anchored to cameras whose directions are this far apart, radians, so that these
// tell where it is should the lens change. Guessed.
constexpr double kSubjectAnchorsApart = Radians(2);

// Tried with a simulated subject that is moved and with hands before one that is not
// (tests/coverage/session/capture_checks_test); otherwise guessed.
constexpr double kWatchOver_s = 0.3;  // frames that are taken together
// Share of the expected points that are found, of the subject's against the others: below the first the
// subject's are gone, above the second they are there again.
constexpr double kWatchGoneShare = 0.45, kWatchThereShare = 0.8;
constexpr double kWatchStaysGone_s = 0.5;  // so long they have to be gone: a hand passes before the subject
// Frames for which a point must have been known before the subject's points were gone: a subject that has
// moved soon gets new points of its own, which would be found.
constexpr int kWatchKnownForFrames = 20;
constexpr double kWatchFewestPerFrame = 8;  // points that should have been found; fewer say nothing
constexpr std::size_t kWatchFewestFrames = 3;
// If a smaller share of the other points is found, the tracker itself has a problem.
constexpr double kWatchRestShare = 0.5;

// Returns the subject's distance where none is given: the mean depth of the tracked points near the middle of
// the picture. (Thesis, section 3.1: "the system initializes its distance with the average depth of feature
// points".) The nearest and farthest quarter of the points may belong to what stands before or behind the
// subject and do not count. Returns none where there are too few.
std::optional<double> DepthNearCenter(const std::vector<tracking::VisiblePoint>& points,
                                      const CameraModel& camera) {
  constexpr double kReach = 0.25;     // of the image's height; more takes in what stands beside it. Guessed
  constexpr std::size_t kFewest = 8;  // fewer are met by chance. Guessed
  const Eigen::Vector2d middle(0.5 * camera.width, 0.5 * camera.height);
  std::vector<double> depths;
  for (const tracking::VisiblePoint& point : points)
    if ((point.img - middle).norm() < kReach * camera.height && point.depth > 0)
      depths.push_back(point.depth);
  if (depths.size() < kFewest) return std::nullopt;
  std::ranges::sort(depths);
  const std::size_t from = depths.size() / 4, to = depths.size() - from;
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += depths[i];
  return sum / static_cast<double>(to - from);
}

}  // namespace

std::optional<double> DepthOfUpright(const Eigen::Vector3d& foot, const Rigid3& cam_from_board) {
  const Eigen::Vector3d at = cam_from_board * foot, up = cam_from_board.rotation * -Eigen::Vector3d::UnitZ();
  // The point of the line that is nearest to the optical axis: where it is nearest to it as seen along the
  // axis.
  constexpr double kLeastSlant = 0.02;  // of a line that is seen as a line. Guessed.
  const double slant = up.head<2>().squaredNorm();
  if (slant < kLeastSlant * kLeastSlant) return std::nullopt;
  const double depth = at.z() - at.head<2>().dot(up.head<2>()) / slant * up.z();
  return depth > 0 ? std::optional(depth) : std::nullopt;
}

std::string ProblemOf(const Subject& subject, const std::optional<Rigid3>& cam_from_world,
                      FrameSource source) {
  if (!(subject.radius > 0) || !std::isfinite(subject.radius) || !subject.center_in_world.allFinite())
    return fmt::format(
        "a subject needs a radius above 0 and a centre of numbers, not radius {:g}; write x,y,z,radius in "
        "world units",
        subject.radius);
  if (!cam_from_world) return {};
  const Eigen::Vector3d center_in_cam = *cam_from_world * subject.center_in_world;
  if (center_in_cam.norm() <= subject.radius)
    return fmt::format(
        "the camera is inside that sphere (its centre is {:.3g} away, its radius {:.3g}); give a smaller "
        "radius{}",
        center_in_cam.norm(), subject.radius, IsTaken(source) ? "" : " or step back");
  if (center_in_cam.z() <= 0)
    return fmt::format("that subject is behind the camera; {}correct the numbers",
                       IsTaken(source) ? "" : "turn the camera towards it first, or ");
  return {};
}

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
  const double fewest = kWatchFewestPerFrame * static_cast<double>(frames_.size());
  if (frames_.size() < kWatchFewestFrames || sum.expected_on < fewest || sum.expected_off < fewest)
    return std::nullopt;
  const double on = sum.found_on / sum.expected_on, off = sum.found_off / sum.expected_off;
  return off < kWatchRestShare ? std::nullopt : std::optional(on / off);
}

bool SubjectWatch::Moved(double time_s, std::span<const tracking::ExpectedPoint> points,
                         const Subject& subject) {
  if (gone_since_s_) ++frames_gone_;
  Tally now{.time_s = time_s};
  for (const tracking::ExpectedPoint& point : points) {
    if (point.times_expected < kWatchKnownForFrames + frames_gone_) continue;
    const bool on = (point.position_in_world - subject.center_in_world).norm() <= subject.radius;
    (on ? now.expected_on : now.expected_off) += point.find_rate;
    (on ? now.found_on : now.found_off) += point.found;
  }
  while (!frames_.empty() &&
         (time_s - frames_.front().time_s > kWatchOver_s || time_s < frames_.front().time_s))
    frames_.pop_front();
  frames_.push_back(now);
  if (const auto share = ShareFound()) {
    if (*share < kWatchGoneShare && !gone_since_s_) gone_since_s_ = time_s;
    if (*share > kWatchThereShare) gone_since_s_.reset(), frames_gone_ = 0;
  }
  return gone_since_s_ && time_s - *gone_since_s_ >= kWatchStaysGone_s;
}

void CaptureSubject::Set(const Subject& subject) {
  record_.SetSubject(subject);
  reporter_.Reset();
  watch_.Reset();
  anchors_.Clear();
  moved_ = false;
  is_stale_ = false;
}

void CaptureSubject::FindFirst(const tracking::Track& track) {
  tracked_in_a_row_ = track.state == tracking::TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  finding_ = false;
  if (!track.cam_from_world) return;
  if (std::exchange(map_id_, track.map_id) != track.map_id && !anchors_.empty() && record_.views().empty()) {
    is_stale_ = true;
    anchors_.Clear();
    say_("the tracker began a new map: the subject is looked for again");
  }
  if (IsPlaced()) {
    if (anchors_.empty() ||
        (record_.views().empty() &&
         anchors_.StandsApart(*record_.subject(), *track.cam_from_world, kSubjectAnchorsApart)))
      Anchor(track);
    return;
  }
  const auto depth = options_.turntable ? DepthOfUpright(options_.turntable->Middle(), *track.cam_from_world)
                                        : DepthNearCenter(poses_.VisiblePoints(), lens_.live());
  finding_ = depth.has_value();
  if (!depth || tracked_in_a_row_ < options_.stable_frames) return;
  Set(SubjectOnAxis(lens_.live(), *track.cam_from_world, *depth, options_.subject_size));
  found_ = true;
}

void CaptureSubject::RecordedFrom(const tracking::Track& track) {
  if (record_.subject()) Anchor(track);
}

// In a world that markers or a given trajectory hold, the map's corrections do not move the subject.
void CaptureSubject::Anchor(const tracking::Track& track) {
  if (!poses_.IsMetric()) anchors_.Add(*record_.subject(), track);
}

namespace {

struct Change {
  double moved = 0, grown = 0;  // shares of the radius
  double Most() const { return std::max(moved, grown); }
};

Change ChangeOf(const Subject& from, const Subject& to) {
  return {(to.center_in_world - from.center_in_world).norm() / from.radius,
          std::abs(to.radius / from.radius - 1)};
}

}  // namespace

std::optional<Subject> CaptureSubject::Followed() const {
  const std::optional<Subject> now = is_stale_ ? std::nullopt : anchors_.Now(poses_);
  if (!now || ChangeOf(*record_.subject(), *now).Most() < kSubjectWorthFollowing) return std::nullopt;
  return now;
}

void CaptureSubject::SayFollowed(const Subject& from) const {
  const Change change = ChangeOf(from, *record_.subject());
  if (change.Most() < kSubjectWorthTelling) return;
  say_(fmt::format("the map was corrected: the subject's sphere moved with it, by {:.0f} % of its radius{}",
                   100 * change.moved,
                   change.grown < kSubjectWorthFollowing
                       ? ""
                       : fmt::format(", and its radius is {:.0f} % of before",
                                     100 * record_.subject()->radius / from.radius)));
}

std::optional<Subject> CaptureSubject::UnderNewLens(const CameraModel& before) {
  return is_stale_ ? std::nullopt : anchors_.ReplaceLens(lens_.live(), before, poses_);
}

void CaptureSubject::Place(const Subject& subject, const std::optional<Rigid3>& cam_from_world) {
  const std::string problem = ProblemOf(subject, cam_from_world, source_);
  found_ &= !problem.empty();
  if (!problem.empty()) return say_("the subject stays as it was: " + problem);
  Move(subject);
}

void CaptureSubject::Find(const FindSubject& asked, const std::optional<Rigid3>& cam_from_world) {
  const double share = asked.width_share.value_or(options_.subject_size);
  if (!cam_from_world)
    return say_("the subject stays as it was: the camera's position is not known at the moment");
  if (!(share > 0 && share <= kRectangleShare))
    return say_(
        fmt::format("the subject stays as it was: its sphere cannot be {:g} of the picture's width, the "
                    "safety rectangle is {:g}",
                    share, kRectangleShare));
  const auto depth = asked.depth ? asked.depth : DepthNearCenter(poses_.VisiblePoints(), lens_.live());
  if (!depth)
    return say_(
        fmt::format("the subject stays as it was: too few tracked points in the middle of the picture; "
                    "{}give its depth (subject depth D)",
                    IsTaken(source_) ? "" : "aim at it, or "));
  Move(SubjectOnAxis(lens_.live(), *cam_from_world, *depth, share));
}

void CaptureSubject::Move(const Subject& subject) {
  const auto share = [this] { return record_.map() ? record_.map()->CoveredShare() : 0; };
  const double before = share();
  Set(subject);
  const Eigen::Vector3d& center = subject.center_in_world;
  const std::size_t views = record_.views().size();
  std::string painted;
  if (views > 0) painted = fmt::format("; {} painted anew", Counted(views, "view"));
  if (views > 0 && record_.map()->options().cap)
    painted += fmt::format(": {:.1f} % covered, before it was {:.1f} %", 100 * share(), 100 * before);
  say_(fmt::format("the subject is at {:.3g} {:.3g} {:.3g}, radius {:.3g}{}", center.x(), center.y(),
                   center.z(), subject.radius, painted));
}

void CaptureSubject::Watch(const tracking::Track& track, double time_s) {
  if (!record_.map() || track.state != tracking::TrackState::kTracking) return;
  const bool moved = watch_.Moved(time_s, poses_.ExpectedPoints(), record_.map()->subject());
  if (std::exchange(moved_, moved) || !moved) return;
  say_(
      fmt::format("the subject seems to have moved: new views do not fit the earlier ones; {}take back the "
                  "views since then, or place the subject anew",
                  IsTaken(source_) ? "" : "put it back and "));
}

}  // namespace ulf::coverage
