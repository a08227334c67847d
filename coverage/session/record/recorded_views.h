// Owns what a running capture knows of its recorded views: the id that each has on disk, the keyframe of the
// tracker's map to which it is anchored, and the pose that follows from both, as of the last correction. All
// others take poses from here, or hear of every change as an Observer. The disk comes first: the spool gives
// a view its id and accepts corrected poses, and only accepted changes are made here.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/criterion_view.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

class RecordedViews {
 public:
  struct Entry {
    int id = 0;
    std::optional<tracking::Anchored> anchor;  // none: of an earlier session, whose poses do not change
    Rigid3 cam_from_world;
    // The track of the view's frame, for ReestimatePoses(); null: the lens will not change.
    std::shared_ptr<const tracking::Track> track = {};
    std::optional<CameraModel> camera = {};  // none: the capture's own, which may change (capture_lens.h)
    const CameraModel& CameraOr(const CameraModel& of_capture) const { return camera ? *camera : of_capture; }
  };
  // Is notified of every change after it was made, in the order of subscription.
  class Observer {
   public:
    virtual ~Observer() = default;
    virtual void Added(const Entry& view, const Image& image) = 0;
    virtual void Removed(const Entry& view) = 0;
    // All poses are updated; the capture's lens may have changed with them.
    virtual void Moved(const RecordedViews& views) = 0;
  };
  // Begins with the views of earlier sessions, of which observers are not notified.
  explicit RecordedViews(const LightField& recorded_before);
  // `observer` outlives all changes.
  void Subscribe(Observer& observer) { observers_.push_back(&observer); }

  // `image`: the view's picture, for the observers.
  void Add(const Entry& view, const Image& image = {});
  // Returns false when there is no view with this id.
  bool Remove(int id);
  // Changes when views have been moved or removed; added views are appended.
  std::uint64_t revision() const { return revision_; }
  bool empty() const { return views_.empty(); }
  std::size_t size() const { return views_.size(); }
  std::vector<int> Ids() const;  // in the order of recording
  const std::vector<Entry>& views() const { return views_; }
  std::map<int, Rigid3> Poses() const;  // by id

  // Returns the poses of the anchors in the tracker's present map, by id.
  std::map<int, Rigid3> PosesNow(const tracking::PoseSource& poses) const;
  // Returns the largest change of any view from its pose here to the one in `poses`, radians as seen from the
  // subject (without one, from a distance of 1 world unit).
  double LargestMove(const std::map<int, Rigid3>& poses, const Subject* subject) const;
  // Corrects anchors after the lens was replaced by one that displaces image points by `lens_change` of their
  // distance from the middle: a view's pose relative to its keyframe is wrong by that share. Where the error
  // matters, as seen from the subject (without one, from a distance of 1 world unit), the pose is estimated
  // again from the points that the view's frame showed.
  void ReestimatePoses(const tracking::PoseSource& poses, double lens_change, const Subject* subject);
  // Gives every view its corrected pose, cam_from_world by id.
  void SetPoses(const std::map<int, Rigid3>& poses);

  // `of_capture`: the camera of the views of this session.
  std::vector<CriterionView> ForCriterion(const CameraModel& of_capture, int coverage_width_px) const;

 private:
  std::vector<Entry> views_;
  std::vector<Observer*> observers_;
  std::uint64_t revision_ = 0;
};

// A view at the moment of recording, with its pixels; its present pose is in RecordedViews.
struct RecordedFrame {
  int id = 0;
  Frame frame;
  CameraModel camera;  // of the frame: a photograph's is not the live picture's
  Rigid3 cam_from_world;
};

}  // namespace ulf::coverage
