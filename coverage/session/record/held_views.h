// The recorded views as a running capture knows them: from the moment the spool has taken one, with the id
// that it will have on disk, and the keyframe that its pose hangs on.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/criterion.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

struct HeldView {
  int id = 0;
  std::optional<tracking::Anchored> anchor;  // none: fixed where an earlier session recorded it
  Rigid3 cam_from_world;
};

class HeldViews {
 public:
  explicit HeldViews(const LightField& recorded_before);
  void Add(const HeldView& view) { views_.push_back(view); }
  // False: there is none with this id.
  bool Remove(int id);
  bool empty() const { return views_.empty(); }
  std::size_t size() const { return views_.size(); }
  std::vector<int> Ids() const;               // in the order of recording
  std::vector<int> LastIds(int count) const;  // the newest first
  const std::vector<HeldView>& views() const { return views_; }

  // What their anchors mean now, by id.
  std::map<int, Rigid3> PosesNow(const tracking::PoseSource& poses) const;
  // Of any view, against the poses that are held: an angle, as seen from a subject.
  double LargestMove(const std::map<int, Rigid3>& poses, const Subject* subject) const;
  void MoveTo(const std::map<int, Rigid3>& poses);

  std::vector<CriterionView> ForCriterion(const CameraModel& camera, int coverage_width_px) const;

 private:
  std::vector<HeldView> views_;
};

}  // namespace ulf::coverage
