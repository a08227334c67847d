#include "coverage/session/record/recorded_views.h"

#include <algorithm>
#include <utility>

namespace ulf::coverage {

RecordedViews::RecordedViews(const LightField& recorded_before) {
  for (const View& view : recorded_before.views)
    views_.push_back({view.id, {}, view.cam_from_world, {}, recorded_before.CameraOf(view)});
}

void RecordedViews::Add(const Entry& view, const Image& image) {
  views_.push_back(view);
  for (Observer* observer : observers_) observer->Added(view, image);
}

bool RecordedViews::Remove(int id) {
  const auto found = std::ranges::find(views_, id, &Entry::id);
  if (found == views_.end()) return false;
  const Entry removed = std::move(*found);
  views_.erase(found);
  ++revision_;
  for (Observer* observer : observers_) observer->Removed(removed);
  return true;
}

std::vector<int> RecordedViews::Ids() const {
  std::vector<int> ids;
  for (const Entry& view : views_) ids.push_back(view.id);
  return ids;
}

std::map<int, Rigid3> RecordedViews::Poses() const {
  std::map<int, Rigid3> poses;
  for (const Entry& view : views_) poses[view.id] = view.cam_from_world;
  return poses;
}

std::map<int, Rigid3> RecordedViews::PosesNow(const tracking::PoseSource& poses) const {
  std::map<int, Rigid3> now;
  for (const Entry& view : views_)
    now[view.id] = view.anchor ? poses.PoseOf(*view.anchor) : view.cam_from_world;
  return now;
}

double RecordedViews::LargestMove(const std::map<int, Rigid3>& poses, const Subject* subject) const {
  double largest = 0;
  for (const Entry& view : views_) {
    const Rigid3 moved = poses.at(view.id) * view.cam_from_world.Inverse();
    const double distance = subject ? (view.cam_from_world * subject->center_in_world).norm() : 1;
    largest = std::max({largest, RotationAngle(moved.rotation), moved.translation.norm() / distance});
  }
  return largest;
}

void RecordedViews::ReestimatePoses(const tracking::PoseSource& poses, double lens_change,
                                    const Subject* subject) {
  // An error, radians as seen from the subject. Guessed: about what one frame's own points leave open.
  constexpr double kWorthFinding = 5e-4;
  for (Entry& view : views_) {
    if (!view.anchor || !view.track) continue;
    const Rigid3 now = poses.PoseOf(*view.anchor);
    // The anchor's lengths are in its keyframe's unit of then.
    tracking::Anchored aside = *view.anchor;
    aside.cam_from_keyframe.translation.x() += 1;
    const double unit = (poses.PoseOf(aside).translation - now.translation).norm();
    const double distance = subject ? (now * subject->center_in_world).norm() : 1;
    const double off = lens_change * unit * view.anchor->cam_from_keyframe.translation.norm();
    const auto found = off > kWorthFinding * distance ? poses.PoseNow(*view.track) : std::nullopt;
    if (!found) continue;
    Rigid3 found_from_now = *found * now.Inverse();
    found_from_now.translation /= unit;
    view.anchor->cam_from_keyframe = found_from_now * view.anchor->cam_from_keyframe;
  }
}

void RecordedViews::SetPoses(const std::map<int, Rigid3>& poses) {
  for (Entry& view : views_) view.cam_from_world = poses.at(view.id);
  ++revision_;
  for (Observer* observer : observers_) observer->Moved(*this);
}

std::vector<CriterionView> RecordedViews::ForCriterion(const CameraModel& of_capture,
                                                       int coverage_width_px) const {
  std::vector<CriterionView> views;
  for (const Entry& view : views_)
    views.push_back(CriterionView::From(view.CameraOr(of_capture), view.cam_from_world, coverage_width_px));
  return views;
}

}  // namespace ulf::coverage
