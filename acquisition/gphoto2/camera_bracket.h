// A camera's own exposure bracketing: its settings make it take exposures so many stops apart, faster than
// they could be asked for one by one, and are put back afterwards.
//
// By the names of libgphoto2's ptp2 driver. Canon EOS: `aeb` ("+/- 2"), three exposures, one a release in
// `drivemode` Single. Nikon: `bracketing`, `bracketset`, `aebracketingstep` ("2 EV") and
// `aebracketingpattern` ("3 images (normal, under and over)"), or an `aebracketingcount` that fits already;
// all from one release with `capturemode` Burst and `burstnumber`, where it has them.
//
// Nothing tells which photograph has which exposure but its Exif. The exposure in the middle, which is the
// view's own, is taken again: its stops are 0.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

// A setting's name in the driver, and a value of it.
using NamedValue = std::pair<std::string, std::string>;

struct CameraBracketPlan {
  std::vector<NamedValue> settings;  // in the order in which they are written; only those that are to change
  int exposures = 0;                 // the one in the middle among them
  bool one_release = false;          // brings all of them
};

// None: the camera does not offer just these exposures, so many stops from the present one. `setting`: what
// the camera has under a name.
std::optional<CameraBracketPlan> PlanCameraBracket(
    const std::vector<double>& stops,
    const std::function<std::optional<GphotoSetting>(const std::string&)>& setting);

// Belongs to the camera's thread. A busy camera is asked again in later rounds, so long as it may be busy.
class CameraBracket {
 public:
  CameraBracket(GphotoCamera& camera, const CameraSettings& settings, double busy_s,
                std::function<void(const std::string&)> notice)
      : camera_(camera), settings_(settings), busy_s_(busy_s), notice_(std::move(notice)) {}

  // False: it does not offer these exposures, or failed at them before.
  bool Begin(const std::vector<double>& stops);
  // Until the settings are back where they were.
  bool IsRunning() const { return is_running_; }
  // How many photographs the release brings that is to be made now; 0: none is, not yet or no more.
  int Next();
  // The camera did not take its settings: nothing was released.
  bool HasRefused() const { return has_refused_; }
  // Of a photograph by the exposure time in its Exif: the stops that were asked for, 0 for the middle; none:
  // neither.
  std::optional<double> StopsOf(const std::optional<double>& told_s);
  void GiveUp(bool camera_is_gone);

 private:
  bool Write();

  GphotoCamera& camera_;
  const CameraSettings& settings_;
  const double busy_s_;
  const std::function<void(const std::string&)> notice_;
  bool is_running_ = false, has_refused_ = false;
  bool is_useless_ = false;  // on this camera
  std::vector<double> stops_;
  double middle_s_ = 0;
  int to_come_ = 0;
  bool one_release_ = false;
  std::deque<NamedValue> to_write_, before_;
  std::optional<std::chrono::steady_clock::time_point> refused_since_;
  std::chrono::steady_clock::time_point again_;
  std::chrono::milliseconds pause_{0};
};

}  // namespace ulf::acquisition
