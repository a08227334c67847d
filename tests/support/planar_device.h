// A device without a simulator: a textured plane seen from given poses, each rendered by one homography. It
// is cheap enough for hundreds of frames in a test; each frame may have a fault.
#pragma once

#include <optional>
#include <vector>

#include "acquisition/device/device.h"
#include "core/geometry/rigid3.h"
#include "tests/support/floors.h"

namespace ulf::test {

enum class Fault {
  kNone,
  kBlurred,      // defocused
  kOverexposed,  // white
  kBlack,
  kIncomplete,  // pixels missing
  kNoPose,      // nothing is known of its pose
};

struct PlanarShot {
  Rigid3 cam_from_world;
  Fault fault = Fault::kNone;
};

struct PlanarDeviceOptions {
  CameraModel camera = CameraModel::Pinhole(320, 240, 300);
  double fps = 15;
  double exposure_s = 0;     // 0: unknown, so that no speed is judged
  bool lost_at_end = false;  // the cable is pulled after the last shot; else the device has ended
};

// Shows the plane z = 0 of the world: a square of 4 units around the origin with a random pattern of fixed
// seed, grey around it.
class PlanarDevice : public Device {
 public:
  explicit PlanarDevice(std::vector<PlanarShot> shots, const PlanarDeviceOptions& options = {});
  DeviceInfo Info() const override;
  std::optional<CameraModel> Camera() const override { return options_.camera; }
  bool IsLive() const override { return false; }
  void Start() override { started_ = true; }
  std::optional<Frame> Next(std::chrono::milliseconds timeout) override;
  void Stop() override { started_ = false; }
  DeviceState State() const override;
  DeviceStatistics Statistics() const override { return statistics_; }

 private:
  cv::Mat Render(const PlanarShot& shot) const;

  std::vector<PlanarShot> shots_;
  PlanarDeviceOptions options_;
  cv::Mat pattern_;
  bool started_ = false;
  std::size_t next_ = 0;
  DeviceStatistics statistics_;
};

}  // namespace ulf::test
