#include "coverage/session/record/held_views.h"

#include <algorithm>

namespace ulf::coverage {

HeldViews::HeldViews(const LightField& recorded_before) {
  for (const View& view : recorded_before.views) views_.push_back({view.id, {}, view.cam_from_world});
}

bool HeldViews::Remove(int id) {
  return std::erase_if(views_, [id](const HeldView& view) { return view.id == id; }) > 0;
}

std::vector<int> HeldViews::Ids() const {
  std::vector<int> ids;
  for (const HeldView& view : views_) ids.push_back(view.id);
  return ids;
}

std::vector<int> HeldViews::LastIds(int count) const {
  std::vector<int> ids;
  for (auto view = views_.rbegin(); view != views_.rend() && static_cast<int>(ids.size()) < count; ++view)
    ids.push_back(view->id);
  return ids;
}

std::map<int, Rigid3> HeldViews::PosesNow(const tracking::PoseSource& poses) const {
  std::map<int, Rigid3> now;
  for (const HeldView& view : views_)
    now[view.id] = view.anchor ? poses.PoseOf(*view.anchor) : view.cam_from_world;
  return now;
}

double HeldViews::LargestMove(const std::map<int, Rigid3>& poses, const Subject* subject) const {
  double largest = 0;
  for (const HeldView& view : views_) {
    const Rigid3 moved = poses.at(view.id) * view.cam_from_world.Inverse();
    // Against the distance to the subject both are angles.
    const double distance = subject ? (view.cam_from_world * subject->center_in_world).norm() : 1;
    largest = std::max({largest, RotationAngle(moved.rotation), moved.translation.norm() / distance});
  }
  return largest;
}

void HeldViews::MoveTo(const std::map<int, Rigid3>& poses) {
  for (HeldView& view : views_) view.cam_from_world = poses.at(view.id);
}

std::vector<CriterionView> HeldViews::ForCriterion(const CameraModel& camera, int coverage_width_px) const {
  std::vector<CriterionView> views;
  for (const HeldView& view : views_)
    views.push_back(CriterionView::From(camera, view.cam_from_world, coverage_width_px));
  return views;
}

}  // namespace ulf::coverage
