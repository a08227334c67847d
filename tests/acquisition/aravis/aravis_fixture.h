// Tests of the Aravis device: a camera in a process of its own, in a network of this process's own.
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <memory>
#include <vector>

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/device/device.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"

namespace ulf::test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The driver alone, without what opens it again.
inline std::unique_ptr<Device> OpenDriver(const std::string& uri) {
  return OpenAravisDevice(DeviceUri::Parse(uri));
}

inline std::vector<Frame> Take(Device& device, std::size_t count) {
  std::vector<Frame> frames;
  const auto start = Clock::now();
  while (frames.size() < count && SecondsSince(start) < 20 && device.State() == DeviceState::kStreaming)
    if (auto frame = device.Next(500ms)) frames.push_back(std::move(*frame));
  EXPECT_EQ(frames.size(), count) << "frames within 20 s; " << device.Info().problem;
  return frames;
}

class CameraInNamespace : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::optional<std::string> why_not = EnterLoopbackNamespace();
    if (why_not) GTEST_SKIP() << *why_not;
  }

  void StartCamera(const std::string& serial = "T1", const std::string& loss = "0",
                   const std::string& address = "127.0.0.1", const std::string& description = "") {
    std::vector<std::string> command{FAKE_GIGE_CAMERA, serial, loss, address};
    if (!description.empty()) command.push_back(description);
    camera_.reset();  // before the next one wants its port
    camera_ = std::make_unique<ChildProcess>(command);
    ASSERT_THAT(camera_->ReadUntil("ready", 20), ::testing::HasSubstr("ready"));
  }
#ifdef FULL_CAMERA
  void StartFullCamera() { StartCamera("F1", "0", "127.0.0.1", FULL_CAMERA); }
#endif

  std::unique_ptr<ChildProcess> camera_;
};

}  // namespace ulf::test
