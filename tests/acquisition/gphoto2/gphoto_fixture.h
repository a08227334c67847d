// A tethered camera on loopback and the device that the stock driver makes of it.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/gphoto2/gphoto_device.h"
#include "tests/support/floors.h"
#include "tests/support/ptpip_camera.h"
#include "tests/support/test_paths.h"

namespace ulf::test {

using std::chrono::milliseconds;

// A picture that says its number: its mean is the number.
inline std::string NumberedJpeg(int number, int width, int height) {
  cv::Mat picture(height, width, CV_8UC3, cv::Scalar::all(number % 200));
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes);
  return {bytes.begin(), bytes.end()};
}

inline std::string FileName(int number, const char* ending = "JPG") {
  return fmt::format("DSC_{:04}.{}", number, ending);
}

inline std::vector<PtpipFile> NumberedPhotograph(int number) {
  return {{FileName(number), NumberedJpeg(number, 960, 640)}};
}

class GphotoTest : public ::testing::Test {
 protected:
  // The library keeps settings of its own in the home folder.
  void SetUp() override { setenv("HOME", home_.path().c_str(), 1); }

  void Begin(PtpipCamera::Photograph photograph = NumberedPhotograph,
             const PtpipCameraOptions& options = {}) {
    camera_ = std::make_unique<PtpipCamera>([this] { return NumberedJpeg(++live_, 320, 240); },
                                            std::move(photograph), options);
  }
  std::unique_ptr<Device> Open(const std::string& options = "") {
    return OpenGphotoDevice(DeviceUri::Parse(camera_->Uri() + options));
  }

  // The first frame that fits; none after ten seconds.
  static std::optional<Frame> Await(Device& device, const std::function<bool(const Frame&)>& fits) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      auto frame = device.Next(milliseconds(100));
      if (frame && fits(*frame)) return frame;
      if (!frame && device.State() != DeviceState::kStreaming) break;
    }
    return std::nullopt;
  }
  static std::optional<Frame> AwaitStill(Device& device) {
    return Await(device, [](const Frame& frame) { return frame.kind == FrameKind::kStill; });
  }
  static std::optional<Frame> AwaitLive(Device& device) {
    return Await(device, [](const Frame& frame) { return frame.kind == FrameKind::kLive; });
  }
  // Reads frames away until the condition holds; false after ten seconds.
  static bool Until(Device& device, const std::function<bool()>& holds) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      if (holds()) return true;
      device.Next(milliseconds(20));
    }
    return false;
  }
  // All that the device has said so far.
  const std::string& Said(Device& device) {
    for (const DeviceEvent& event : device.TakeEvents()) said_ += event.text + "\n";
    return said_;
  }

  ScratchFolder home_;
  std::atomic<int> live_{0};
  std::string said_;
  std::unique_ptr<PtpipCamera> camera_;
};

}  // namespace ulf::test
