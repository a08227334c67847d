// Where the tracked surroundings have taken the subject. The subject is a sphere in the world; when the tracker
// corrects its map (a loop closes, an adjustment moves keyframes), what stands in the sphere moves with the
// points around it, and the sphere has to follow.
//
// Each anchor is the sphere as it stood beside one keyframe, kept as the views' poses are (tracking/map/anchored.h),
// so that it follows both the keyframe and its unit of length. The sphere is where the anchors' mean is.
#pragma once

#include <optional>
#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

class SubjectAnchors {
 public:
  void Clear() { anchors_.clear(); }
  bool empty() const { return anchors_.empty(); }
  // `track`: with a pose and an anchor, of the same moment as `subject`; else nothing happens.
  void Add(const Subject& subject, const tracking::Track& track);
  // None without anchors.
  std::optional<Subject> Now(const tracking::PoseSource& poses) const;

 private:
  struct Anchor {
    tracking::Anchored center, rim;  // of cameras that stand there
  };
  std::vector<Anchor> anchors_;
};

}  // namespace ulf::coverage
