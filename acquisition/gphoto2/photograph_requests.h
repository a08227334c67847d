// Keeps requests to a tethered camera, for a photograph or for the exposures of a bracket, until the
// photographs have arrived, were refused, or are overdue.
//
// Requests may come from any thread; everything else belongs to the camera's thread. A bracket is taken by
// the camera's own bracketing where it offers those exposures (camera_bracket.h), else one photograph after
// another (shutter_bracket.h).
//
// The first photograph announced after a release counts as its answer, although the photographer may have
// released it on the body: PTP's events name their transaction, but libgphoto2 does not pass that on.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "acquisition/gphoto2/camera_bracket.h"
#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/shutter_bracket.h"
#include "core/base/mutex.h"
#include "core/frames/frame.h"

namespace ulf::acquisition {

class PhotographRequests {
 public:
  // `camera` and `settings` must outlive this. `gone`: whether a call failed because the camera is gone.
  PhotographRequests(GphotoCamera& camera, CameraSettings& settings,
                     const std::function<void(const std::string&)>& notice,
                     std::function<bool(const GphotoResult&)> gone);

  // Request one photograph, and those of a bracket (Device::RequestExposures). They return false while
  // earlier ones are still to come, or if exposures cannot be requested.
  bool RequestPhotograph();
  bool RequestExposures(const std::vector<double>& stops);
  // Returns whether exposures can be requested, as ReadSettings() found.
  bool TakesExposures() const { return sets_shutter_; }

  // Call it before the camera's thread runs, when all settings are made.
  void ReadSettings() { sets_shutter_ = shutter_bracket_.IsPossible(); }
  // Call it often. Releases the shutter if due, trying a busy camera for 10 s; waits 60 s for its
  // photographs. A failure is a notice.
  void Work();
  // Returns whether the shutter was released and not all of its photographs have come.
  bool IsReleased() const { return released_at_.has_value(); }
  // Returns whether the shutter was released and none of its photographs has been announced.
  bool AwaitsAnnouncement() const { return IsReleased() && stems_.empty(); }
  double ReleasedHostS() const { return released_host_s_; }  // the last release, since the epoch
  // Call it when a photograph of that stem is announced. Returns whether it answers the release.
  bool IsAnsweredBy(const std::string& stem);
  // Call it before Came(). Sets asked_stops of a bracket's photograph; without `told_s` (Exif's exposure
  // time) the camera's own bracket also sets exposure_s to 0.
  void TellExposure(Frame& still, const std::optional<double>& told_s);
  // Notes that a photograph of the release at `released_s` (ReleasedHostS()) has arrived, or will not.
  void Came(double released_s);
  // Call it when the camera is lost, and Work() no more. A released photograph may still come.
  void ReleaseNoMore() { still_wanted_ = false; }
  // Drops the request for the present photograph, as if it had come.
  void Clear();
  // Call it before the thread ends: drops the rest of a bracket, and restores what it has changed on the
  // camera, or reports it.
  void GiveUpBracket(bool camera_is_gone);

 private:
  void ReleaseNextExposure();
  void Release();

  GphotoCamera& camera_;
  const std::function<void(const std::string&)> notice_;
  const std::function<bool(const GphotoResult&)> gone_;
  ShutterBracket shutter_bracket_;
  CameraBracket camera_bracket_;

  bool said_busy_ = false;
  std::optional<std::chrono::steady_clock::time_point> asked_since_, released_at_;
  std::chrono::steady_clock::time_point again_;  // a busy camera is not asked before
  std::chrono::milliseconds pause_{0};
  double released_host_s_ = 0;
  int expected_ = 1, came_ = 0;              // photographs of the release
  std::set<std::string> stems_;              // of those that were announced
  std::optional<double> stops_being_taken_;  // by a photograph whose shutter time was set for it

  // Shared.
  std::atomic<bool> still_wanted_{false}, exposures_wanted_{false};
  bool sets_shutter_ = false;
  Mutex mutex_;
  std::vector<double> exposures_asked_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::acquisition
