#include "coverage/session/subject/capture_subject.h"

#include <fmt/format.h>

#include <utility>

#include "core/base/counted.h"
#include "coverage/bound/sphere_outline.h"
#include "coverage/session/subject/subject_finder.h"

namespace ulf::coverage {

void CaptureSubject::Set(const Subject& subject) {
  record_.SetSubject(subject);
  outlook_.Forget();
  watch_.Forget();
  moved_ = false;
}

void CaptureSubject::FindFirst(const tracking::Track& track) {
  tracked_in_a_row_ = track.state == tracking::TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  finding_ = false;
  if (record_.map() || !track.cam_from_world) return;
  const auto depth = DepthNearCenter(poses_.VisiblePoints(), camera_);
  finding_ = depth.has_value();
  if (!depth || tracked_in_a_row_ < options_.stable_frames) return;
  Set(SubjectOnAxis(camera_, *track.cam_from_world, *depth, options_.size));
  found_ = true;
}

void CaptureSubject::Place(const Subject& subject, const std::optional<Rigid3>& cam_from_world) {
  const std::string problem = ProblemOf(subject, cam_from_world);
  found_ &= !problem.empty();
  if (!problem.empty()) return say_("the subject stays as it was: " + problem);
  Move(subject);
}

void CaptureSubject::Find(const FindSubject& asked, const std::optional<Rigid3>& cam_from_world) {
  const double share = asked.width_share.value_or(options_.size);
  if (!cam_from_world)
    return say_("the subject stays as it was: the camera's position is not known at the moment");
  if (!(share > 0 && share <= options_.rectangle_share))
    return say_(
        fmt::format("the subject stays as it was: its sphere cannot be {:g} of the picture's width, the "
                    "safety rectangle is {:g}",
                    share, options_.rectangle_share));
  const auto depth = asked.depth ? asked.depth : DepthNearCenter(poses_.VisiblePoints(), camera_);
  if (!depth)
    return say_(
        "the subject stays as it was: too few tracked points in the middle of the picture; aim at it, or "
        "give its depth (subject depth D)");
  Move(SubjectOnAxis(camera_, *cam_from_world, *depth, share));
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
      "the subject seems to have moved: views from now on do not fit the earlier ones; put it back and take "
      "back the views since then, or place the subject anew");
}

}  // namespace ulf::coverage
