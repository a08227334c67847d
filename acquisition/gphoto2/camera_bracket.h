// Uses a camera's own exposure bracketing: its settings make it take exposures so many stops apart, faster
// than single requests, and are restored afterwards.
//
// Settings have the names of libgphoto2's ptp2 driver. Canon EOS: `aeb` ("+/- 2"), three exposures, one a
// release in `drivemode` Single. Nikon: `bracketing`, `bracketset`, `aebracketingstep` ("2 EV") and
// `aebracketingpattern` ("3 images (normal, under and over)"), or an `aebracketingcount` that fits already;
// all from one release with `capturemode` Burst and `burstnumber`, where it has them.
//
// Only Exif data tell which photograph has which exposure. The exposure in the middle, which is the view's
// own, is taken again: its stops are 0.
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

// Returns none when the camera does not offer just these exposures, so many stops from the present one.
// `setting` returns the camera's setting of a name.
std::optional<CameraBracketPlan> PlanCameraBracket(
    const std::vector<double>& stops,
    const std::function<std::optional<CameraFeature>(const std::string&)>& setting);

// Belongs to the camera's thread. A busy camera is asked again in later rounds, until its time is over.
class CameraBracket {
 public:
  CameraBracket(GphotoCamera& camera, const CameraSettings& settings, double busy_s,
                std::function<void(const std::string&)> notice)
      : camera_(camera), settings_(settings), busy_s_(busy_s), notice_(std::move(notice)) {}

  // Returns false when it does not offer these exposures, or failed at them before.
  bool Begin(const std::vector<double>& stops);
  // Returns true until the settings are restored.
  bool IsRunning() const { return is_running_; }
  // Returns how many photographs the release makes that is due now; 0: none is due.
  int Next();
  // Returns whether the camera did not take its settings, so that nothing was released.
  bool HasRefused() const { return has_refused_; }
  // Returns the requested stops of a photograph by the exposure time in its Exif data, 0 for the middle; none
  // when it is none of these.
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
