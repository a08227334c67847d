// Watches what may change on a tethered camera while it is used, by itself or by hand: settings, image
// format, battery, card. Each change is reported once. Belongs to the camera's thread.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

class CameraWatch {
 public:
  // `camera` and `settings` must outlive this object. `notice` gets messages for the user.
  CameraWatch(GphotoCamera& camera, CameraSettings& settings, std::function<void(const std::string&)> notice)
      : camera_(camera), settings_(settings), notice_(std::move(notice)) {}

  // Call it before the first Poll(), when all settings are made. `target_is_memory`: from ChooseTarget().
  void Begin(bool target_is_memory);
  // Looks for changes. Returns a result that is not ok() if the camera may be gone.
  GphotoResult Poll();
  // Returns whether the camera tells of its storage; if not, Poll() cannot notice that the camera is gone.
  bool HasStorage() const { return has_storage_; }

 private:
  void LookAtFormat();
  void LookAtBatteryAndCard();

  GphotoCamera& camera_;
  CameraSettings& settings_;
  const std::function<void(const std::string&)> notice_;
  std::vector<GphotoStorage> storages_;
  bool target_is_memory_ = false, has_storage_ = false;
  bool said_battery_ = false, said_full_ = false, said_raw_only_ = false;
};

}  // namespace ulf::acquisition
