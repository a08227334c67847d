// Tests: acquisition/aravis/aravis_device, tracking/tracker/tracker.
// A day in five minutes: 1280x1024 at 30 frames a second over GigE Vision while a tracker works on what it
// can take. Every frame that the camera sent must have come.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "acquisition/device/device.h"
#include "acquisition/device/frame_queue.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/simulated_camera.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tracking/tracker/tracker.h"

namespace ulf::gige_long_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::HasSubstr;

constexpr double kFps = 30;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Takes the newest frame there is, again and again, and keeps count.
struct TrackingWork {
  FrameQueue newest{1};
  Tracker tracker{SimulatedIntrinsics(1280, 1024)};
  int stepped = 0, tracked = 0;
  std::vector<double> latencies_ms;

  void Run() {
    while (true) {
      const auto frame = newest.Pop(200ms);
      if (!frame && newest.IsClosed()) return;
      if (!frame) continue;
      const double now_s =
          std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
      latencies_ms.push_back(1e3 * (now_s - frame->device_time_s));
      ++stepped;
      tracked += tracker.Step(*frame).state == TrackState::kTracking;
    }
  }
};

TEST(GigeLong, LosesNoFrameInFiveMinutesOfTracking) {
  if (const auto why_not = test::EnterLoopbackNamespace()) GTEST_SKIP() << *why_not;
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_NE(binary, nullptr) << "run through ctest";
  // By hand, ULF_LONG_SECONDS makes it shorter.
  const char* seconds = std::getenv("ULF_LONG_SECONDS");
  const double duration_s = seconds ? std::atof(seconds) : 300;

  test::ChildProcess camera({binary, "simulate", "studio", "--loop", "90", "--fps", "30", "--options",
                             "width=1280&height=1024&format=Mono8&look_away=0"});
  ASSERT_THAT(camera.ReadUntil("serving", 180), HasSubstr("serving"));
  const auto device = OpenDevice("aravis:127.0.0.1?format=Mono8");
  TrackingWork work;
  std::thread tracking([&] { work.Run(); });
  device->Start();
  const auto begin = Clock::now();
  std::uint64_t whole = 0;
  while (SecondsSince(begin) < duration_s && device->State() == DeviceState::kStreaming)
    if (auto frame = device->Next(500ms)) {
      whole += frame->status == FrameStatus::kComplete;
      work.newest.Push(std::move(*frame));
    }
  const DeviceStatistics statistics = device->Statistics();
  device->Stop();
  work.newest.Close();
  tracking.join();

  std::sort(work.latencies_ms.begin(), work.latencies_ms.end());
  ASSERT_FALSE(work.latencies_ms.empty());
  const auto latency = [&](double share) {
    return work
        .latencies_ms[static_cast<std::size_t>(share * static_cast<double>(work.latencies_ms.size() - 1))];
  };
  std::printf(
      "%llu frames in %.0f s: missing %llu, incomplete %llu, dropped at the queue %llu; the tracker took %d "
      "and "
      "followed %d; device timestamp to tracker: median %.1f ms, 99th percentile %.1f ms\n",
      static_cast<unsigned long long>(whole), duration_s, static_cast<unsigned long long>(statistics.missing),
      static_cast<unsigned long long>(statistics.incomplete),
      static_cast<unsigned long long>(statistics.dropped), work.stepped, work.tracked, latency(0.5),
      latency(0.99));
  EXPECT_EQ(statistics.missing, 0u);
  EXPECT_EQ(statistics.incomplete, 0u);
  EXPECT_EQ(statistics.dropped, 0u);
  // The camera itself may skip a moment when it gets no processor; what it sends must be near its rate.
  EXPECT_GT(static_cast<double>(whole), 0.97 * kFps * duration_s);
  EXPECT_GT(work.stepped, duration_s) << "more than one frame a second";
  EXPECT_GT(work.tracked, work.stepped / 2);
}

}  // namespace
}  // namespace ulf::gige_long_test
