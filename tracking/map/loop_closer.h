// Closing loops: the camera has come round to what it saw long ago, and drift has made two copies of it.
//
// Every new keyframe asks the index for keyframes that look alike and share no points with it. A candidate is
// verified as a lost camera is: a similarity from matched points in the seeded sampler (three points, Umeyama
// 1991), then guided matching over the candidate's whole neighbourhood, refinement, and the share of points
// found. What was measured is this camera's pose in the old part's world, and how much larger the old part's
// unit is. A loop is believed when several keyframes in a row say the same and nothing verified says
// otherwise, and when the correction is no more than drift over the way between can be: two places that only
// look alike lie as far apart as the way between them. Then a pose graph spreads the error (Strasdat et al.
// 2010), points follow their keyframes, and those seen from both sides are merged. Bundle adjustment of
// everything is the caller's part.
//
// Runs in the thread that changes the map: reads without the lock, takes it to write.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/similarity3.h"
#include "tracking/map/map.h"
#include "tracking/map/relocalizer.h"
#include "tracking/tracker/frame_locator.h"

namespace ulf::tracking {

struct LoopOptions {
  unsigned seed = 1;
  int agreeing = 3;             // keyframes that must say the same
  int min_points = 40;          // found by guided matching, for a keyframe to say anything
  double max_drift = 0.25;      // the correction against the way since the old part was seen
  double max_turn_deg = 35;     // of the correction
  double max_scale_change = 2;  // of the correction, either way
};

// One keyframe's word: what it sees belongs to an old part of the map.
struct LoopHypothesis {
  int recent = -1, old = -1;  // keyframes
  // The recent camera, in its own units, from the old camera's.
  Similarity3 recent_from_old;
  std::vector<std::pair<int, int>> same;  // points: recent id, old id
  int points = 0;                         // that guided matching found
};

struct ClosedLoop {
  std::vector<int> recent, old;  // keyframes on either side, which may see each other's points
};

class LoopCloser {
 public:
  LoopCloser(const CameraModel& camera, SharedMap& shared, const KeyframeIndex& index,
             const LoopOptions& options = {});

  // To be called once for every keyframe after the neighbourhood has been adjusted. A value: the map has been
  // corrected.
  std::optional<ClosedLoop> Examine(int newest);
  // Whether `recent` sees what `old` saw; none without proof.
  std::optional<LoopHypothesis> Verify(int recent, int old) const;
  void Reset();

 private:
  std::vector<int> Candidates(int newest) const;
  bool Plausible(const LoopHypothesis& hypothesis) const;
  bool Agree(const LoopHypothesis& a, const LoopHypothesis& b) const;
  Similarity3 Correction(const LoopHypothesis& hypothesis) const;
  std::optional<ClosedLoop> Close(const std::vector<LoopHypothesis>& agreeing);
  void MergePoints(const LoopHypothesis& hypothesis) ULF_REQUIRES(shared_.mutex);

  CameraModel camera_;
  SharedMap& shared_;
  const Map& map_;
  const KeyframeIndex& index_;
  LoopOptions options_;
  FrameLocator locator_;
  std::vector<LoopHypothesis> pending_;
  int last_closed_ = -1;  // keyframe
};

// Moves keyframes, and points with the keyframe that made them: `cam_from_world` by keyframe id, in the
// keyframe's units of before. The map's lock is held.
void MoveMap(Map& map, const std::vector<std::pair<int, Similarity3>>& cam_from_world);

}  // namespace ulf::tracking
