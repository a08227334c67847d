// Defines the state of a running capture after a frame: all that the operator display, a progress line and a
// simulated operator know of it. It is immutable once published; images and the coverage map are shared, not
// copied.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/mutex.h"
#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/capture_prediction.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/guidance.h"
#include "coverage/bound/view_decision.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/session/preflight.h"
#include "coverage/session/record/recorded_views.h"
#include "coverage/session/turn_back.h"
#include "coverage/session/watch/mistake_watch.h"
#include "tracking/tracker/start_progress.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

// kFrames, kSeconds: a limit of CaptureOptions is reached; kEnded: the device has no more frames; kSignal:
// CaptureHooks::stop_requested; kDisk: a Failure() of the spool; kClosed: FinishCapture was requested.
enum class StoppedBecause { kCovered, kFrames, kSeconds, kEnded, kSignal, kDeviceLost, kDisk, kClosed };
const char* Name(StoppedBecause why);  // for reports that programs read: "device_lost"

class CaptureRequests;
struct LiveMesh;

struct CaptureState {
  FrameSource source = FrameSource::kCamera;
  bool metric = false;  // world units are metres
  std::uint64_t frames = 0;
  double device_time_s = 0;  // of the newest frame
  std::optional<double> frames_per_s;
  std::uint64_t dropped = 0;  // by the device and on the way, since the start

  // The live frame, with the camera's distortion.
  Image live;
  CameraModel camera;
  CameraModel recorded_camera;    // of all views of this session
  int recorded_camera_index = 0;  // in the light field
  bool takes_stills = false;      // photographs are recorded in place of live frames

  tracking::TrackState tracking = tracking::TrackState::kInitializing;
  std::string tracking_words;  // what to do while there is no pose; empty while there is one
  std::optional<Rigid3> cam_from_world;
  std::optional<CameraTurn> turned;              // while there is no pose; none: not known
  std::optional<tracking::StartProgress> start;  // while a map is being started; else none
  std::vector<tracking::VisiblePoint> points;    // found in this frame

  // The axis of a turntable, upwards; none: the camera moves and the subject does not turn.
  std::optional<Eigen::Vector3d> table_up_in_world;
  bool without_subject = false;  // posed photographs are recorded, no subject is looked for
  bool finding_subject = false;  // the subject's distance is being found from the middle of the image
  std::optional<Subject> subject;
  std::optional<Subject> proposed_subject;      // a sphere that fits better (subject_proposal.h)
  bool subject_moved = false;                   // the subject's points no longer agree with the others
  std::shared_ptr<const CoverageMap> coverage;  // null without a subject
  std::vector<int> view_ids;                    // ascending, in the order of coverage->views()
  // The newest view of this session; null before. It is not in view_ids once it has been taken back.
  std::shared_ptr<const RecordedFrame> newest_view;
  std::filesystem::path light_field;  // its folder, where every other view is or will soon be
  std::optional<double> covered;      // share of the cap; none without one
  // Directions that were covered until poses were corrected or views were taken back, and their share of the
  // cap (without one, of what was covered): they must be recorded again.
  std::vector<Eigen::Vector3d> reopened;
  double reopened_share = 0;
  // The error that was measured at frames, by direction; null: nothing is measured.
  std::shared_ptr<const ErrorMap> errors;
  CoverGoal cover;
  // The newest mesh of geometry (record/live_geometry.h); null: none yet, or none at all.
  std::shared_ptr<const LiveMesh> mesh;
  // False: none will come while capturing, because no geometry is made or it has failed.
  bool mesh_may_come = true, errors_may_come = true;
  Guidance guidance;
  std::optional<CapturePrediction> prediction;  // for the subject as it was placed; none before
  std::optional<double> views_expected;         // those recorded and those that the open rest will take

  Decision decision;                 // of this frame, with its reason
  bool recording = true;             // false: paused by request, or not begun
  bool waits_to_begin = false;       // recording begins on request; `preflight` says what holds it
  std::optional<int> recorded_view;  // id of the view recorded since the state before
  std::string why_waiting;           // for the device or the disk, in words; empty: not waiting
  std::string device_problem;        // empty: none
  std::optional<std::uint64_t> disk_left_bytes;
  std::optional<bool> exposure_locked;  // none: cannot be known
  std::vector<PreflightItem> preflight;
  std::vector<NoticedMistake> mistakes;  // so far
  double seconds = 0;                    // by the device's clock, since the first frame
  // The last lines that the capture reported, of `times_said` in all.
  std::vector<std::string> said;
  std::uint64_t times_said = 0;
  std::uint64_t requests_answered = 0;  // compare with what CaptureRequests::Push() returned
  std::optional<StoppedBecause> ended;  // if it is set, the light field is being closed
};

using SharedCaptureState = std::shared_ptr<const CaptureState>;

// Describes how far to go nearer or back, for somebody with a camera in the hand: "5 cm" where the scale is
// known, else "5 %" of the distance.
struct LengthToGo {
  enum class Unit { kPercent, kMillimetres, kCentimetres, kMetres };
  double amount = 0;
  Unit unit = Unit::kPercent;
  static LengthToGo Of(const CaptureState& state, double from_distance, double to_distance);
  std::string Text() const;  // "5 cm"
  // Returns the share that the text's rounded length is of a distance in metres.
  double ShareOf(double distance_m) const;
};

// Returns the way to the next viewpoint, for a person without a display: "8° right, 3° up, 5 cm nearer", in
// the camera's axes; before a turntable "turn the table 8° clockwise, the camera 3° up", as seen from above.
// It is empty when there is no target, or less than a degree to go, and where pictures are taken already.
std::string WayInWords(const CaptureState& state);

// Returns over which surface the review is drawn, in words.
std::string MeshInWords(const CaptureState& state);
// Returns where errors are from, or why there are none, in words.
std::string ErrorsInWords(const CaptureState& state);

// Hands the newest state from the session's thread to the display's. Older states are dropped, because
// whatever must not be missed is in every later state, too.
class CaptureFeed {
 public:
  void Publish(SharedCaptureState state) {
    const MutexLock lock(mutex_);
    if (!closed_) state_ = std::move(state);
  }
  // Drops what is published from now on, because the display is gone.
  void Close() {
    const MutexLock lock(mutex_);
    closed_ = true;
    state_.reset();
  }
  SharedCaptureState Newest() const {  // null before the first frame
    const MutexLock lock(mutex_);
    return state_;
  }

 private:
  mutable Mutex mutex_;
  bool closed_ ULF_GUARDED_BY(mutex_) = false;
  SharedCaptureState state_ ULF_GUARDED_BY(mutex_);
};

// The functions that a capture calls while it runs (capture_session.h).
struct CaptureHooks {
  std::function<bool()> stop_requested;  // asked before every frame
  CaptureRequests* requests = nullptr;   // answered between two frames
  // Called with every complete live frame and every photograph before it is processed.
  std::function<void(const Frame&)> keep_frame;
  // Called after every live frame; the state is made only when this hook is set.
  std::function<void(const SharedCaptureState&)> after_frame;
  // Called ten times a second when no frame comes, after every photograph, and once before the light field is
  // closed.
  std::function<void(const SharedCaptureState&)> while_waiting;
  std::function<void(const std::string&)> say;  // a line for each event
  // Called after the capture with a description of each closing step, which may take long.
  std::function<void(const std::string&)> closing;
};

}  // namespace ulf::coverage
