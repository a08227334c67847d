// Uses a camera's own exposure bracketing: its settings make it take exposures so many stops apart, faster
// than single requests, and are restored afterwards.
//
// Settings have the names of libgphoto2's ptp2 driver. Canon EOS: `aeb` ("+/- 2"), three exposures, one per
// release in `drivemode` Single. Nikon: `bracketing`, `bracketset`, `aebracketingstep` ("2 EV") and
// `aebracketingpattern` ("3 images (normal, under and over)"), or an `aebracketingcount` that fits already;
// one release takes all of them on cameras with `capturemode` Burst and `burstnumber`.
//
// Only Exif data tell which photograph has which exposure. The camera takes the exposure in the middle, which
// the view has already, once more: its stops are 0.
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
  int exposures = 0;                 // with the one in the middle
  bool one_release = false;          // one release takes all of them; false: each takes one
};

// Plans exposures so many stops from the present one, which is not among `stops`. Returns none if the camera
// does not offer just these. `setting` returns the camera's setting of a name.
std::optional<CameraBracketPlan> PlanCameraBracket(
    const std::vector<double>& stops,
    const std::function<std::optional<CameraFeature>(const std::string&)>& setting);

// Belongs to the camera's thread, which calls Next() and releases the shutter as it says until IsRunning()
// is false. A busy camera is asked again for `busy_s` seconds. `notice` gets messages for the user.
class CameraBracket {
 public:
  CameraBracket(GphotoCamera& camera, const CameraSettings& settings, double busy_s,
                std::function<void(const std::string&)> notice)
      : camera_(camera), settings_(settings), busy_s_(busy_s), notice_(std::move(notice)) {}

  // Returns false if the camera does not offer these exposures, or failed at a bracket before.
  bool Begin(const std::vector<double>& stops);
  // Returns true until the settings are restored.
  bool IsRunning() const { return is_running_; }
  // Writes the settings that are due. Returns how many photographs the shutter takes if it is released now;
  // 0: it must not be released.
  int Next();
  // Returns whether the camera refused the settings, so that nothing was released.
  bool HasRefused() const { return has_refused_; }
  // Returns the stops of a photograph by the exposure time in its Exif data, `told_s`: 0 for the middle, none
  // if it was not requested or there is no time.
  std::optional<double> StopsOf(const std::optional<double>& told_s);
  // Ends the bracket and restores the settings, or asks for that by `notice`.
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
