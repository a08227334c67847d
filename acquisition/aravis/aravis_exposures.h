// Takes requested exposures one after another while the camera streams (Device::RequestExposures).
//
// A camera that has a sequencer (SFNC SequencerMode) and reports each frame's exposure (chunk data) changes
// the exposure by itself, from frame to frame. For any other camera, each exposure time is set, and the frame
// that has it is awaited: with chunk data the first that reports it; without, the fourth after the setting,
// because a camera may have exposed the next one already and two more may be in transit. Before the fourth a
// frame's exposure is 0 (unknown). An exposure that no frame has in three seconds is left out, with a note.
//
// Only the thread that takes frames may call the functions, except Kind() and Request().
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/aravis_setting.h"
#include "acquisition/device/device.h"
#include "core/base/mutex.h"
#include "core/frames/frame.h"

namespace ulf::acquisition {

class AravisExposures {
 public:
  // `frames_tell`: chunk data report each frame's exposure. `triggered_by_software`: only the requested frame
  // is in transit, so that the second after a setting has the exposure.
  AravisExposures(const AravisSession& session, bool frames_tell, bool triggered_by_software);

  ExposureRequests Kind() const { return kind_; }
  // Reads the camera's abilities again: an automatic or the chunk data may have been switched off.
  void LookAgain();
  void LookAgain(bool frames_tell) {
    frames_tell_ = frames_tell;
    LookAgain();
  }
  // Requests exposures, in stops from the present one. kBusy: earlier ones are to come, or the camera cannot.
  StillRequest Request(const std::vector<double>& stops) ULF_EXCLUDES(mutex_);
  // Begins the exposures that were requested. Call it often.
  void Step();
  // Call it for each complete frame. If the frame has the exposure that is due, this sets Frame::asked_stops,
  // and the camera's exposure to the next one.
  void Label(Frame& frame);
  // Drops the exposures that are still to come, and sets the exposure from before them.
  void Restore();
  // Returns messages for people, each once.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }

 private:
  using Clock = std::chrono::steady_clock;
  struct Wanted {
    double stops = 0;
    double exposure_s = 0;
  };
  bool SetTime(double exposure_s);
  bool StartSequencer();
  void StopSequencer();
  void Next();

  const AravisSession& session_;
  AravisNumber exposure_;  // microseconds
  bool frames_tell_;
  const bool triggered_by_software_;
  std::atomic<ExposureRequests> kind_{ExposureRequests::kNone};
  mutable Mutex mutex_;
  std::vector<double> asked_ ULF_GUARDED_BY(mutex_);
  bool busy_ ULF_GUARDED_BY(mutex_) = false;
  std::deque<Wanted> wanted_;  // still to come, then the exposure before
  double before_s_ = 0;        // the exposure before; 0: none are asked for
  double set_s_ = 0;           // as the camera has it now
  int frames_since_set_ = 0;
  Clock::time_point set_at_;
  bool sequencer_runs_ = false;
  bool said_bounds_ = false;
  std::vector<std::string> notes_;
};

}  // namespace ulf::acquisition
