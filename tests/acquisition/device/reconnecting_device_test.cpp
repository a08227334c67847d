// Tests: acquisition/device/reconnecting_device, acquisition/device/driver_search,
// acquisition/device/event_log, acquisition/device/transport_figures, acquisition/device/background_closer.
#include "acquisition/device/reconnecting_device.h"

#include <gmock/gmock.h>

#include <atomic>
#include <functional>
#include <thread>

#include "acquisition/device/background_closer.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/scripted_device.h"

namespace ulf::test::reconnecting_device_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kPatient_s = 60;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::unique_ptr<Device> Open(const std::shared_ptr<ScriptedCamera>& camera, double patience_s = kPatient_s) {
  return MakeReconnectingDevice(camera->OpenDriver(),
                                {.where_it_was = [camera](const DeviceInfo&) { return camera->OpenDriver(); },
                                 .elsewhere = nullptr,
                                 .patience_s = patience_s});
}

// Asks for frames until `enough` says so; what it handed out on the way.
std::vector<Frame> Watch(Device& device, const std::function<bool()>& enough, double at_most_s = 30) {
  std::vector<Frame> frames;
  for (const auto start = Clock::now(); !enough() && SecondsSince(start) < at_most_s;)
    if (auto frame = device.Next(20ms)) frames.push_back(std::move(*frame));
  EXPECT_TRUE(enough()) << "not within " << at_most_s << " s";
  return frames;
}

std::function<bool()> In(const Device& device, DeviceState state) {
  return [&device, state] { return device.State() == state; };
}

std::function<bool()> After(double seconds) {
  return [start = Clock::now(), seconds] { return SecondsSince(start) >= seconds; };
}

std::vector<DeviceEventKind> Kinds(const std::vector<DeviceEvent>& events) {
  std::vector<DeviceEventKind> kinds;
  for (const DeviceEvent& event : events) kinds.push_back(event.kind);
  return kinds;
}

// What was let go of in the background is gone, too.
void WaitUntilClosed(const std::shared_ptr<ScriptedCamera>& camera, int open = 0) {
  for (const auto start = Clock::now(); camera->Open() > open && SecondsSince(start) < 20;)
    std::this_thread::sleep_for(5ms);
  EXPECT_EQ(camera->Open(), open);
}

TEST(ReconnectingDevice, GoesRoundTheStateMachine) {
  const auto camera = ScriptedCamera::Make();
  auto device = Open(camera);
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  EXPECT_FALSE(device->Next(0ms)) << "not started";
  device->Start();
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
  Watch(*device, After(0.2));
  EXPECT_THAT(device->TakeEvents(), ::testing::IsEmpty());
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kFaulted));
  EXPECT_THAT(device->Info().problem, HasSubstr("cable is out"));
  EXPECT_FALSE(device->Info().available);
  Watch(*device, In(*device, DeviceState::kReconnecting));
  Watch(*device, After(0.5));
  EXPECT_EQ(device->State(), DeviceState::kReconnecting);
  camera->PlugIn();
  const auto back = Clock::now();
  Watch(*device, In(*device, DeviceState::kStreaming));
  EXPECT_LT(SecondsSince(back), 3);
  EXPECT_TRUE(device->Info().problem.empty());
  const auto events = device->TakeEvents();
  EXPECT_THAT(Kinds(events), ElementsAre(DeviceEventKind::kFaulted, DeviceEventKind::kReconnecting,
                                         DeviceEventKind::kRestored));
  EXPECT_THAT(events[0].text, HasSubstr("cable is out"));
  EXPECT_EQ(device->Statistics().reconnects, 1u);
  device->Stop();
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  device.reset();
  WaitUntilClosed(camera);
}

TEST(ReconnectingDevice, DeliversWhatWaitedAtTheFault) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera);
  device->Start();
  const auto first = Watch(*device, After(0.1));
  std::this_thread::sleep_for(400ms);  // the queue of eight is full
  camera->Unplug();
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(Watch(*device, In(*device, DeviceState::kFaulted)).size(), 8u);
}

TEST(ReconnectingDevice, CountersAddUpAndSettingsDoNot) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera);
  device->Start();
  std::uint64_t frames = 0;
  for (int round = 0; round < 3; ++round) {
    frames += Watch(*device, After(0.2)).size();
    camera->Unplug();
    frames += Watch(*device, In(*device, DeviceState::kReconnecting)).size();
    camera->PlugIn();
    frames += Watch(*device, In(*device, DeviceState::kStreaming)).size();
  }
  const DeviceStatistics statistics = device->Statistics();
  EXPECT_EQ(statistics.delivered, frames);
  EXPECT_EQ(statistics.reconnects, 3u);
  using Figure = std::pair<TransportFigure, double>;
  const auto all = static_cast<double>(frames);
  EXPECT_THAT(
      statistics.transport,
      ElementsAre(Figure(TransportFigure::kPacketsReceived, 10.0 * all),
                  Figure(TransportFigure::kPacketSize, 1400), Figure(TransportFigure::kPayloadBytes, 307'200),
                  Figure(TransportFigure::kSetFps, 15), Figure(TransportFigure::kExposureUs, 4000),
                  Figure(TransportFigure::kBytesReceived, 1e5 * all),
                  Figure(TransportFigure::kWhileSettling, 4), Figure(TransportFigure::kClockShared, 1)));
}

TEST(ReconnectingDevice, TimesGoOnThroughClockResets) {
  for (const bool switched_off : {false, true}) {
    const auto camera = ScriptedCamera::Make();
    const auto device = Open(camera);
    device->Start();
    std::this_thread::sleep_for(300ms);  // so that a clock that begins anew is behind
    const double before_s = Watch(*device, After(0.2)).back().device_time_s;
    const auto pulled = Clock::now();
    camera->Unplug();
    Watch(*device, In(*device, DeviceState::kReconnecting));
    camera->PlugIn(0ms, switched_off);
    auto frames = Watch(*device, In(*device, DeviceState::kStreaming));
    const double gap_s = SecondsSince(pulled);
    for (Frame& frame : Watch(*device, After(0.2))) frames.push_back(std::move(frame));
    EXPECT_NEAR(frames.front().device_time_s - before_s, gap_s, 0.5) << switched_off;
    double last_s = before_s;
    for (const Frame& frame : frames) {
      EXPECT_GT(frame.device_time_s, last_s);
      last_s = frame.device_time_s;
    }
    const std::string said = device->TakeEvents().back().text;
    EXPECT_EQ(said.find("clock restarted") != std::string::npos, switched_off) << said;
  }
}

TEST(ReconnectingDevice, TellsTheTimeSinceTheLastFrame) {
  const auto camera = ScriptedCamera::Make();
  camera->SetNoticingTakes(1500ms);  // a driver waits for answers before it calls a camera lost
  const auto device = Open(camera);
  device->Start();
  const double last_s = Watch(*device, After(0.2)).back().host_time_s;
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kReconnecting));
  camera->PlugIn();
  const double first_s = Watch(*device, In(*device, DeviceState::kStreaming)).front().host_time_s;
  EXPECT_GT(first_s - last_s, 1.5);
  EXPECT_THAT(device->TakeEvents().back().text,
              HasSubstr(fmt::format("streams again, {:.1f} s after its last frame", first_s - last_s)));
}

TEST(ReconnectingDevice, RefusesAnotherCameraInItsPlace) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera);
  device->Start();
  Watch(*device, After(0.1));
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kReconnecting));
  camera->SetSerial("S2");
  camera->PlugIn();
  Watch(*device, After(1.5));
  EXPECT_EQ(device->State(), DeviceState::kReconnecting);
  camera->SetSerial("S1");
  Watch(*device, In(*device, DeviceState::kStreaming));
  const auto events = device->TakeEvents();
  EXPECT_THAT(Kinds(events), ElementsAre(DeviceEventKind::kFaulted, DeviceEventKind::kReconnecting,
                                         DeviceEventKind::kNotice, DeviceEventKind::kRestored));
  EXPECT_THAT(events[2].text, AllOf(HasSubstr("serial S2"), HasSubstr("serial S1")));
}

TEST(ReconnectingDevice, OtherImagesAreRefused) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera);
  device->Start();
  Watch(*device, After(0.1));
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kReconnecting));
  camera->SetSize({32, 24});
  camera->PlugIn();
  for (const Frame& frame : Watch(*device, After(1.5)))
    EXPECT_EQ(frame.image.pixels.size(), cv::Size(64, 48));
  EXPECT_EQ(device->State(), DeviceState::kReconnecting);
  camera->SetSize({64, 48});
  Watch(*device, In(*device, DeviceState::kStreaming));
  const auto events = device->TakeEvents();
  EXPECT_THAT(events[2].text, AllOf(HasSubstr("32x24"), HasSubstr("64x48")));
  EXPECT_EQ(Kinds(events).back(), DeviceEventKind::kRestored);
}

TEST(ReconnectingDevice, GivesUpOnAnUnusableCamera) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera, 1);
  device->Start();
  Watch(*device, After(0.1));
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kReconnecting));
  camera->SetSize({32, 24});
  camera->PlugIn();
  Watch(*device, In(*device, DeviceState::kLost));
  EXPECT_THAT(device->TakeEvents().back().text, AllOf(HasSubstr("given up"), HasSubstr("other images")));
  EXPECT_LE(camera->Openings(), 5) << "it waits between two attempts";
}

TEST(ReconnectingDevice, GivesUpAfterItsPatience) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera, 0.5);
  device->Start();
  Watch(*device, After(0.1));
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kLost));
  const auto events = device->TakeEvents();
  EXPECT_THAT(events.back().text, AllOf(HasSubstr("given up"), HasSubstr("no answer")));
  EXPECT_FALSE(device->Next(0ms));
  EXPECT_GE(camera->Openings(), 3) << "tried more than once";
  camera->PlugIn();
  device->Start();  // again by hand
  Watch(*device, After(0.1));
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
}

TEST(ReconnectingDevice, WithoutPatienceALossIsFinal) {
  const auto camera = ScriptedCamera::Make();
  const auto device = Open(camera, 0);
  device->Start();
  Watch(*device, After(0.1));
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kLost));
  EXPECT_EQ(camera->Openings(), 1);
  EXPECT_THAT(Kinds(device->TakeEvents()), ElementsAre(DeviceEventKind::kFaulted));
}

// Neither opening (time-outs) nor closing (retries) of a camera that is gone is waited for.
TEST(ReconnectingDevice, NeverBlocksOnALostCamera) {
  const auto camera = ScriptedCamera::Make();
  auto device = Open(camera);
  device->Start();
  Watch(*device, After(0.1));
  camera->SetOpeningTakes(2s);
  camera->SetClosingTakes(2s);
  camera->Unplug();
  Watch(*device, In(*device, DeviceState::kReconnecting));
  double longest_s = 0;
  for (int i = 0; i < 20; ++i) {
    const auto start = Clock::now();
    device->Next(20ms);
    longest_s = std::max(longest_s, SecondsSince(start));
  }
  EXPECT_LT(longest_s, 1);
  const auto start = Clock::now();
  device->Stop();
  device.reset();
  EXPECT_LT(SecondsSince(start), 1);
  WaitUntilClosed(camera);
}

TEST(ReconnectingDevice, StopsInEveryState) {
  for (const int until_ms : {0, 50, 400, 800}) {
    const auto camera = ScriptedCamera::Make();
    auto device = Open(camera);
    device->Start();
    Watch(*device, After(0.05));
    camera->Unplug();
    Watch(*device, After(1e-3 * until_ms));
    device->Stop();
    EXPECT_EQ(device->State(), DeviceState::kConnected) << until_ms;
    EXPECT_FALSE(device->Next(0ms));
    camera->PlugIn();
    device->Start();
    EXPECT_FALSE(Watch(*device, After(0.3)).empty()) << until_ms;
    device.reset();
    WaitUntilClosed(camera);
  }
}

TEST(ReconnectingDevice, IsFoundBySerialWhereItIsNow) {
  const auto here = ScriptedCamera::Make(), there = ScriptedCamera::Make();
  const auto asked_here = std::make_shared<std::atomic<bool>>(false);
  const auto device = MakeReconnectingDevice(here->OpenDriver(), {.where_it_was =
                                                                      [here, asked_here](const DeviceInfo&) {
                                                                        *asked_here = true;
                                                                        return here->OpenDriver();
                                                                      },
                                                                  .elsewhere =
                                                                      [there](const DeviceInfo& known) {
                                                                        EXPECT_EQ(known.serial, "S1");
                                                                        return there->OpenDriver();
                                                                      },
                                                                  .patience_s = kPatient_s});
  device->Start();
  Watch(*device, After(0.1));
  here->Unplug();
  Watch(*device, In(*device, DeviceState::kFaulted));
  Watch(*device, In(*device, DeviceState::kStreaming));
  EXPECT_TRUE(*asked_here);
  EXPECT_EQ(there->Open(), 1);
}

}  // namespace
}  // namespace ulf::test::reconnecting_device_test
