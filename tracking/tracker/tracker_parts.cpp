// What a lost tracker does: it relocalizes, or begins another part of the map.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "tracking/tracker/tracker_core.h"

namespace ulf::tracking {

bool TrackerCore::Relocalize(TrackedImage& image, Track& track) {
  const StageTimer timer(&track.stages.relocalization_s);
  std::optional<FramePose> found;
  const int joins = shared.joins;
  // Do not search at a marker pose that only the frame before decided (sigma 0).
  if (image.fiducials && image.fiducials->center_sigma > 0 && shared.world_given)
    found = locator.FindAt(image, image.fiducials->cam_from_world);
  if (!found) found = locator.Find(image, mapper.index(), SeedOfFrame());
  return found && ContinueFrom(std::move(*found), joins, image, track);
}

bool TrackerCore::ReturnToMainPart(TrackedImage& image, Track& track) {
  const StageTimer timer(&track.stages.relocalization_s);
  const int joins = shared.joins;
  std::optional<FramePose> found = locator.FindInMainPart(image, mapper.index(), SeedOfFrame());
  return found && ContinueFrom(std::move(*found), joins, image, track);
}

// Continues from a pose that does not follow from the frame before.
bool TrackerCore::ContinueFrom(FramePose found, int joins, TrackedImage& image, Track& track) {
  last = {};
  rows.Forget();
  frame_pose_ = std::move(found);
  if (rows.rolls()) rows.RefineWithRows(image, *frame_pose_, {}, shared.world_given);
  const int before = part;
  if (!Accept(image.time_s, *frame_pose_, joins, track)) return false;
  if (part != before) {
    // A part that was lost within its first frames is worth nothing.
    if (frames_tracked <= kProvenFrames) {
      mapper.WaitUntilIdle();
      mapper.RemovePart(before);
    }
    frames_tracked = kProvenFrames;
  }
  track.relocalized = true;
  spdlog::debug("frame {}: found again", frame);
  return true;
}

// Follows the rotation since the last frame that had a pose, or since the first frame.
void TrackerCore::FollowTurn(const TrackedImage& image, Track& track) {
  if (track.cam_from_world) {
    turns.Forget();
    last_features_ = image.features;
    last_turn_ = track.cam_from_world->rotation;
    return;
  }
  const StageTimer timer(&track.stages.relocalization_s);
  if (!turns.HasBegun() && last_features_) turns.Begin(last_features_, last_turn_);
  track.turn = turns.Step(image.features);
}

bool TrackerCore::MayBeginPart(double time_s) const {
  return options.begin_parts && !shared.world_given && !zoom.IsMoved() && lost_since_s &&
         time_s - *lost_since_s >= kBeginPartAfterS;
}

// Returns whether recorded views or given poses lie in the main part's world.
bool TrackerCore::IsMainPartHeld() const {
  const Map& map = shared.map;
  const int main = map.main_part();
  return std::ranges::any_of(map.living(),
                             [&](int id) ULF_REQUIRES(shared.mutex) {
                               return map.keyframe(id).part == main && map.keyframe(id).pinned;
                             }) ||
         std::ranges::any_of(map.points(), [&](const MapPoint& point) {
           return point.alive && point.part == main && !point.views.empty();
         });
}

// A part that has been followed for longer takes the main one's place, where nothing lies in its world.
void TrackerCore::ChooseMainPart() {
  {
    const MapLock lock(shared);
    const int main = shared.map.main_part();
    if (part == main || frames_of_part[part] <= frames_of_part[main] || IsMainPartHeld()) return;
  }
  mapper.SetMainPart(part);
}

// The part in work was lost within its first frames.
void TrackerCore::Abandon() {
  spdlog::debug("frame {}: lost at once, starting again", frame);
  mapper.WaitUntilIdle();
  mapper.RemovePart(part);
  map_drift.Clear();
  zoom.Forget();
  TrackWithLens(size.working());
  initializer.Restart();
  last = {};
  if (lost_since_s) *lost_since_s -= kBeginPartAfterS;  // begin the next one at once
  const MapLock lock(shared);
  const bool nothing_left = shared.map.living().empty();
  if (nothing_left) {
    turns.Forget();
    last_features_.reset();
  }
  state = nothing_left ? TrackState::kInitializing : TrackState::kLost;
  frames_tracked = nothing_left ? 0 : kProvenFrames;
}

}  // namespace ulf::tracking
