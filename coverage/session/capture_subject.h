// Keeps the subject of a running capture: finds it automatically, places it on request, and detects when it
// was moved. `say` gets a line for everything that a person should know.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/preflight.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/session/record/capture_record.h"
#include "coverage/session/subject_anchors.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

// Returns the depth at which the optical axis passes nearest to the line that stands upright on a board at
// `foot`, metres in the board's frame (z into the sheet). Returns none where the camera looks along the line,
// or the line is behind it.
std::optional<double> DepthOfUpright(const Eigen::Vector3d& foot, const Rigid3& cam_from_board);

// Returns what is wrong with a subject for a camera at this pose, and the way out; empty: nothing.
std::string ProblemOf(const Subject& subject, const std::optional<Rigid3>& cam_from_world,
                      FrameSource source);

// Detects that the subject itself was moved: the map points on it are no longer found where the camera's
// pose, which rests on the other points, predicts them. An object in front of the subject looks the same
// until the points are found again.
//
// Each point is weighted by its find rate, so that points which were always hard to find do not count as
// missing. Points inside the subject's sphere are compared with all others.
class SubjectWatch {
 public:
  // Call it after every tracked frame; returns whether the subject's points have been gone for half a second.
  bool Moved(double time_s, std::span<const tracking::ExpectedPoint> points, const Subject& subject);
  void Reset();

 private:
  struct Tally {
    double time_s = 0;
    double expected_on = 0, found_on = 0;  // on the subject
    double expected_off = 0, found_off = 0;
  };
  // Returns the share of points found on the subject over that off it; none where too few points are
  // expected.
  std::optional<double> ShareFound() const;

  std::deque<Tally> frames_;
  std::optional<double> gone_since_s_;
  int frames_gone_ = 0;  // since then
};

class CaptureSubject {
 public:
  // What is passed by reference outlives it. Before a turntable the subject stands above the middle of a
  // board, whose frame is the world.
  CaptureSubject(CaptureRecord& record, PreflightReporter& reporter, const tracking::PoseSource& poses,
                 const CaptureLens& lens, const CaptureOptions& options, FrameSource source,
                 std::function<void(const std::string&)> say)
      : record_(record),
        reporter_(reporter),
        poses_(poses),
        lens_(lens),
        options_(options),
        source_(source),
        say_(std::move(say)) {}

  // Makes this sphere the subject of record, preflight and watch.
  void Set(const Subject& subject);
  // Call it after every frame: finds the subject while there is none, and again when the tracker has begun a
  // new map before the first view, because the old map's places are void.
  void FindFirst(const tracking::Track& track);
  // Call it when the frame of this track has become a view.
  void RecordedFrom(const tracking::Track& track);
  // Returns where a corrected map has taken the sphere with its surroundings; none: by less than a hundredth
  // of its radius.
  std::optional<Subject> Followed() const;
  void SayFollowed(const Subject& from) const;  // reports a move of a twentieth of the radius or more
  // Returns where the subject is under the lens in use, which replaced `before`: where the pictures show it.
  // Returns none when no sphere could follow.
  std::optional<Subject> UnderNewLens(const CameraModel& before);
  // Place() and Find() answer requests, with the newest frame's pose (none: not known), and report why a
  // request is refused.
  void Place(const Subject& subject, const std::optional<Rigid3>& cam_from_world);
  void Find(const FindSubject& asked, const std::optional<Rigid3>& cam_from_world);
  // Call it after every frame: reports once when the subject was moved (SubjectWatch).
  void Watch(const tracking::Track& track, double time_s);
  // Returns whether the sphere stands in a map that is gone: nothing may be recorded on it until the subject
  // is found again or placed.
  bool IsStale() const { return is_stale_; }
  // Returns whether there is a sphere in the tracker's present map.
  bool IsPlaced() const { return record_.map() && !is_stale_; }
  bool Moved() const { return moved_; }  // by the last Watch()
  // Returns whether a depth was found in the middle of the picture, but tracking is not stable for long
  // enough yet.
  bool Finding() const { return finding_; }
  bool IsFoundAutomatically() const { return found_; }

 private:
  void Anchor(const tracking::Track& track);
  void Move(const Subject& subject);

  CaptureRecord& record_;
  PreflightReporter& reporter_;
  const tracking::PoseSource& poses_;
  const CaptureLens& lens_;
  const CaptureOptions& options_;
  const FrameSource source_;
  const std::function<void(const std::string&)> say_;
  SubjectWatch watch_;
  SubjectAnchors anchors_;
  int map_id_ = -1;        // the tracker's, in which the subject has its place; -1: none yet
  bool is_stale_ = false;  // its place was in a map that is gone
  bool moved_ = false;
  bool finding_ = false;
  bool found_ = false;
  int tracked_in_a_row_ = 0;
};

}  // namespace ulf::coverage
