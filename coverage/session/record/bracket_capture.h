// Takes exposure brackets (CaptureOptions::bracket): when a view has been recorded, it requests the other
// exposures (Device::RequestExposures). Each becomes part of the view on disk, with its pose relative to the
// view, because the hand moves meanwhile. They are merged after the capture (render/stereo/bracket_merge.h).
//
// Frames are tracked all the while. To the tracker a frame of another exposure is shown as the view's
// exposure would have been: brighter or darker by the known ratio. A frame in which the camera is not found
// (too dark, too bright) gets a pose between those of the frames around it.
//
// A live camera's exposures are live frames; a tethered camera's are photographs, found in the map like
// others (still_capture.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/frames/frame.h"
#include "core/geometry/trajectory.h"
#include "coverage/session/record/view_spool.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

struct ExposureBracket {
  int exposures = 3;  // with the view's own
  double stops = 2;   // between neighbours
  // Parses "3x2EV"; throws Refusal that names the accepted form.
  static ExposureBracket Parse(const std::string& text);
  std::string Text() const;
  // Returns the stops of the exposures beside the view's own, in the order in which they are taken: nearest
  // first, shorter before longer.
  std::vector<double> StopsBesideOwn() const;
};

struct BracketCounts {
  std::uint64_t views = 0;       // whose exposures were asked for
  std::uint64_t incomplete = 0;  // of these, views of which some did not come
  std::uint64_t exposures = 0;   // recorded beside the views' own
  std::uint64_t between = 0;     // of these, with a pose between those of other frames
};

// Returns the frame as it would have been with this exposure time and gain: brighter or darker in linear
// light, clipped where it is. The frame is unchanged where one of the exposure times is not known.
Frame AsExposed(const Frame& frame, double exposure_s, double gain);

// A CaptureRecorder has one and calls it in the capture's thread.
class BracketCapture {
 public:
  // `device`, `poses` and `spool` outlive it. `deterministic`: frames keep the device's time as their host
  // time. `say` hears of brackets that stay incomplete.
  BracketCapture(acquisition::Device& device, const tracking::PoseSource& poses, ViewSpool& spool,
                 const ExposureBracket& bracket, bool deterministic,
                 std::function<void(const std::string&)> say);

  // Begins the bracket of a view that was recorded from this frame or photograph.
  void Begin(int view_id, const Frame& frame, const tracking::Track& track);
  bool IsRunning() const { return running_.has_value(); }
  // Returns what the tracker is to see of a live frame.
  Frame ForTracking(const Frame& frame) const;
  // Call it for every live frame. Returns true when it belongs to a bracket, or came while one was taken or
  // before the camera had the views' exposure again, and is no view.
  bool Take(const Frame& frame, const tracking::Track& track);
  // Takes another exposure of a photograph. `track`: its pose; none: not found. Returns false when it was not
  // recorded, because it belongs to no view or has no pose: the caller keeps it.
  bool TakeStill(const Frame& still, const std::optional<tracking::Track>& track);
  // Call it at the end of the capture: exposures that still wait for a pose get the last one.
  void Finish();
  const BracketCounts& counts() const { return counts_; }

 private:
  struct Running {
    int view_id = 0;
    tracking::Track view;
    std::size_t asked = 0, came = 0;
    bool is_asked = false;  // false: the device was busy so far
    double heard_s = 0;     // device time of the view, or of the last exposure that came
  };
  struct Waiting {  // for a pose
    int view_id = 0;
    Rigid3 view_from_world;
    Frame frame;
  };
  void RequestExposures();
  void Record(int view_id, const Frame& frame, const Rigid3& exposure_from_view, bool between);
  void PlaceWaiting(const TimedPose& after);
  void EndIfOver(double now_s, double patience_s);
  bool HasViewsExposure(const Frame& frame) const;

  acquisition::Device& device_;
  const tracking::PoseSource& poses_;
  ViewSpool& spool_;
  const ExposureBracket bracket_;
  const bool deterministic_;
  const std::function<void(const std::string&)> say_;
  std::optional<Running> running_;
  double exposure_s_ = 0, gain_ = 1;  // of the views
  std::optional<double> ended_s_;     // the last bracket
  std::optional<TimedPose> last_;
  std::vector<Waiting> waiting_;
  BracketCounts counts_;
};

}  // namespace ulf::coverage
