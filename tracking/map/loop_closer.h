// Closes loops: the camera has returned to what it saw long ago, and drift has made two copies of it.
//
// For every new keyframe the loop closer asks the index for old keyframes that look alike and share no points
// with it. It verifies a candidate as the tracker verifies a lost camera's pose: a similarity from matched
// points in the sampler (three points, Umeyama 1991), guided matching over the candidate's neighbourhood,
// refinement, and the share of points found. The result is the recent camera's pose as the old points show
// it, and the ratio of the units that lengths have drifted to on either side. A loop is closed when several
// keyframes agree, no verified candidate disagrees, and the correction is small enough to be drift over the
// path between: places that only look alike would need a correction as long as that path. Then a pose graph
// spreads the error (Strasdat et al. 2010), points follow their keyframes, and points seen from both sides
// are merged. The caller adjusts the whole map.
//
// Keyframes of another part of the map (map.h) are found and verified in the same way. No path connects two
// parts, so the correction is not limited; it moves one part as a whole, never the main one.
//
// The mapper owns the loop closer; it reads without the map's lock and takes it to write.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/similarity3.h"
#include "tracking/map/frame_locator.h"
#include "tracking/map/map.h"
#include "tracking/map/relocalizer.h"

namespace ulf::tracking {

// One keyframe's evidence that it shows what an old keyframe saw.
struct LoopHypothesis {
  int recent = -1, old = -1;              // ids of keyframes
  Similarity3 recent_from_old;            // from the old camera's frame and unit to the recent camera's
  std::vector<std::pair<int, int>> same;  // ids of points that are one: recent, old
  int points = 0;                         // number of old points found by guided matching
};

struct ClosedLoop {
  std::vector<int> recent, old;  // ids of keyframes on either side, which may see each other's points
};

class LoopCloser {
 public:
  // So many keyframes must agree before a loop is closed. Fewer close loops between places that look alike,
  // more close them late. Guessed.
  static constexpr int kAgreeing = 3;
  LoopCloser(const CameraModel& camera, OwnedMap& owned, const KeyframeIndex& index, unsigned seed,
             int agreeing = kAgreeing);

  // Call it once for every keyframe after its neighbourhood has been adjusted. Returns a loop if it has
  // closed one, or joined two parts, and corrected the map.
  std::optional<ClosedLoop> Examine(int newest);
  // Verifies that keyframe `recent` sees what `old` saw; none without proof.
  std::optional<LoopHypothesis> Verify(int recent, int old) const;
  void Reset();                               // forgets what earlier keyframes showed
  void SetCamera(const CameraModel& camera);  // replaces the lens; the image size must stay

 private:
  std::vector<int> Candidates(int newest) const;
  std::optional<Rigid3> Propose(int recent, const KeyframePoints& of_recent, int old,
                                const KeyframePoints& of_old, bool rigid) const;
  bool Plausible(const LoopHypothesis& hypothesis) const;
  bool Agree(const LoopHypothesis& a, const LoopHypothesis& b) const;
  Similarity3 Correction(const LoopHypothesis& hypothesis) const;
  std::optional<ClosedLoop> Close(const std::vector<LoopHypothesis>& agreeing);
  bool JoinsParts(const LoopHypothesis& hypothesis) const;
  ClosedLoop Join(const std::vector<LoopHypothesis>& agreeing);
  ClosedLoop Seen(const LoopHypothesis& last) const;
  void MergePoints(const LoopHypothesis& hypothesis) ULF_REQUIRES(owned_.shared.mutex);

  CameraModel camera_;
  OwnedMap& owned_;
  const Map& map_;
  const KeyframeIndex& index_;
  unsigned seed_;
  int agreeing_;
  FrameLocator locator_;
  std::vector<LoopHypothesis> pending_;
  int last_closed_ = -1;  // keyframe
};

// Moves keyframes, and points with the keyframe that observed them first. `cam_from_world` has ids and new
// poses, from the new world to the camera's frame in its old unit. The caller holds the map's lock.
void MoveMap(Map& map, const std::vector<std::pair<int, Similarity3>>& cam_from_world);

}  // namespace ulf::tracking
