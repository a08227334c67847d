// Tests: acquisition/aravis/aravis_watch, acquisition/aravis/aravis_device,
// acquisition/aravis/aravis_discovery, acquisition/gige_vision/gige_vision_probe,
// acquisition/device/frame_id_counter.
//
// What goes wrong between a GigE Vision camera and its program, and how soon that is known. (Killed cameras
// and short pauses: aravis_test; bad links: gige_relay_test.)
#include <gmock/gmock.h>
#include <signal.h>

#include <cstdlib>
#include <thread>

#include "acquisition/device/frame_id_counter.h"
#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::aravis_faults_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kSmall = "aravis:127.0.0.1?roi=320x240+0+0&fps=50&format=Mono8";

class AravisFaults : public CameraInNamespace {};

std::string ErrorOf(const std::string& uri) {
  try {
    OpenDriver(uri);
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << uri << ": no error";
  return "";
}

std::vector<DeviceEventKind> Kinds(const std::vector<DeviceEvent>& events) {
  std::vector<DeviceEventKind> kinds;
  for (const DeviceEvent& event : events) kinds.push_back(event.kind);
  return kinds;
}

double SecondsUntilLost(Device& device) {
  const auto start = Clock::now();
  while (device.State() == DeviceState::kStreaming && SecondsSince(start) < 12) device.Next(20ms);
  EXPECT_EQ(device.State(), DeviceState::kLost);
  return SecondsSince(start);
}

TEST_F(AravisFaults, RestartedCameraStreamsWithItsSettings) {
  StartCamera();
  auto device = OpenDriver(kSmall + std::string("&exposure_us=2500"));
  device->Start();
  Take(*device, 5);
  camera_->Kill();
  std::this_thread::sleep_for(700ms);
  StartCamera("T1");
  const auto back = Clock::now();
  const double until_lost_s = SecondsUntilLost(*device);
  EXPECT_THAT(Kinds(device->TakeEvents()),
              AllOf(Contains(DeviceEventKind::kStalled), Contains(DeviceEventKind::kFaulted)));
  EXPECT_FALSE(device->Info().problem.empty());
  device.reset();
  device = OpenDriver(kSmall + std::string("&exposure_us=2500"));
  device->Start();
  const auto frames = Take(*device, 1);
  const double until_frame_s = SecondsSince(back);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames.front().image.width(), 320) << "a restarted camera has forgotten its settings";
  EXPECT_EQ(frames.front().exposure_s, 0.0025);
  EXPECT_LT(until_frame_s, 3);
  RecordProperty("until_lost_ms", static_cast<int>(1e3 * until_lost_s));
  RecordProperty("until_frame_ms", static_cast<int>(1e3 * until_frame_s));
}

TEST_F(AravisFaults, SilentStreamStallsIsLostAndReopened) {
  StartCamera();
  auto device = OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera_->Signal(SIGUSR1);
  const double until_lost_s = SecondsUntilLost(*device);
  EXPECT_GT(until_lost_s, 2.5);
  EXPECT_LT(until_lost_s, 7);
  EXPECT_THAT(device->Info().problem, HasSubstr("although the camera answers"));
  EXPECT_THAT(Kinds(device->TakeEvents()),
              ::testing::ElementsAre(DeviceEventKind::kStalled, DeviceEventKind::kFaulted));
  const auto lost = Clock::now();
  device.reset();
  device = OpenDriver(kSmall);
  device->Start();
  EXPECT_EQ(Take(*device, 3).size(), 3u);
  EXPECT_LT(SecondsSince(lost), 3) << "control is given back at once";
}

TEST_F(AravisFaults, AShortStallIsSaidAndEndsByItself) {
  StartCamera();
  const auto device = OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera_->Signal(SIGUSR1);
  std::this_thread::sleep_for(1200ms);
  camera_->Signal(SIGUSR2);
  Take(*device, 20);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
  EXPECT_THAT(Kinds(device->TakeEvents()),
              ::testing::ElementsAre(DeviceEventKind::kStalled, DeviceEventKind::kNotice));
}

TEST_F(AravisFaults, ABusyCameraNamesItsController) {
  StartFullCamera();
  const auto first = OpenDriver(kSmall);
  std::this_thread::sleep_for(100ms);
  const auto asked = Clock::now();
  EXPECT_THAT(ErrorOf(kSmall),
              AllOf(HasSubstr("another program"), HasSubstr("127.0.0.1"), HasSubstr("45678")));
  EXPECT_LT(SecondsSince(asked), 6);
  const auto devices = ListDevices();
  EXPECT_FALSE(devices.at(0).available);
  EXPECT_EQ(devices.at(0).serial, "F1");
  EXPECT_THAT(devices.at(0).problem,
              AllOf(HasSubstr("another program"), HasSubstr("this computer"), HasSubstr("UDP port 45678")));
}

// Every command says at once who has the camera, and does not wait in silence.
TEST_F(AravisFaults, ABusyCameraIsSaidAtOnceByEveryCommand) {
  StartFullCamera();
  const auto first = OpenDriver(kSmall);
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_TRUE(binary) << "run through ctest";
  const ScratchFolder scratch;
  const std::string light_field = (scratch / "out").string();
  for (const std::string& command :
       {"record '" + std::string(kSmall) + "' -o " + light_field,
        "capture --no-geometry '" + std::string(kSmall) + "' --focal-px 300 -o " + light_field + "2"}) {
    ChildProcess program({"/bin/sh", "-c", std::string(binary) + " " + command + " 2>&1"});
    EXPECT_THAT(program.ReadUntil("waiting 3.1 s", 30),
                AllOf(HasSubstr("another program controls this camera, from 127.0.0.1"), HasSubstr("45678"),
                      HasSubstr("waiting 3.1 s")))
        << command;
    const auto said = Clock::now();
    EXPECT_THAT(program.ReadUntil("close it", 30), AllOf(HasSubstr("ulf: aravis:"), HasSubstr("45678")))
        << command;
    EXPECT_GT(SecondsSince(said), 2) << "said before the wait, not after it: " << command;
  }
  const auto features = RunUlf("features aravis:127.0.0.1 Gain");
  EXPECT_EQ(features.exit_code, 0);
  EXPECT_THAT(features.errors, AllOf(HasSubstr("45678"), HasSubstr("can be read, not written")));
}

TEST_F(AravisFaults, AbsentCameraIsReportedSoon) {
  const auto start = Clock::now();
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1"),
              AllOf(HasSubstr("no GigE Vision camera answers"), HasSubstr("3956")));
  EXPECT_LT(SecondsSince(start), 2);
  EXPECT_THAT(ErrorOf("aravis:10.1.2.3"), HasSubstr("wrong network"));
}

TEST_F(AravisFaults, TwoCamerasStreamAtOnce) {
  if (std::system("ip addr add 127.0.0.2/8 dev lo 2>/dev/null") != 0)
    GTEST_SKIP() << "no second address can be given to the loopback interface";
  StartCamera("LEFT");
  const auto first_camera = std::move(camera_);
  StartCamera("RIGHT", "0", "127.0.0.2");
  const auto left = OpenDriver("aravis:127.0.0.1?roi=320x240+0+0&fps=30&format=Mono8&queue=64");
  const auto right = OpenDriver("aravis:127.0.0.2?roi=64x48+32+16&fps=30&format=RGB8&queue=64");
  left->Start();
  right->Start();
  for (const auto& [device, serial, channels] :
       {std::tuple(left.get(), "LEFT", 1), std::tuple(right.get(), "RIGHT", 3)}) {
    EXPECT_EQ(device->Info().serial, serial);
    const auto frames = Take(*device, 40);
    ASSERT_EQ(frames.size(), 40u) << serial;
    for (const Frame& frame : frames) {
      EXPECT_EQ(frame.status, FrameStatus::kComplete) << serial;
      EXPECT_EQ(frame.image.pixels.channels(), channels) << serial;
    }
  }
  const auto devices = ListDevices();
  std::vector<std::string> serials;
  for (const DeviceInfo& info : devices) serials.push_back(info.serial);
  EXPECT_THAT(serials, AllOf(Contains("LEFT"), Contains("RIGHT")));
  // One of them goes: the other does not notice.
  camera_->Kill();
  SecondsUntilLost(*right);
  EXPECT_EQ(left->State(), DeviceState::kStreaming);
  Take(*left, 5);
}

// A camera with an address of another network hears the broadcast and answers, but cannot be talked to.
TEST_F(AravisFaults, NamesACameraInAnotherNetwork) {
  const std::string serve =
      std::string(
          "ip link set lo up; until ip link set v1 up 2>/dev/null; do sleep 0.05; done; "
          "ip addr add 10.9.9.9/24 dev v1; ip route add 192.168.77.0/24 dev v1; exec ") +
      FAKE_GIGE_CAMERA + " FAR 0 10.9.9.9";
  camera_ = std::make_unique<ChildProcess>(
      std::vector<std::string>{"/usr/bin/unshare", "-n", "/bin/sh", "-c", serve});
  std::this_thread::sleep_for(500ms);
  const std::string wire = fmt::format(
      "ip link add v0 type veth peer name v1 netns {} 2>/dev/null && ip addr add 192.168.77.1/24 dev v0 && "
      "ip link set v0 up",
      camera_->Pid());
  if (std::system(wire.c_str()) != 0) GTEST_SKIP() << "no pair of network interfaces can be made here";
  ASSERT_THAT(camera_->ReadUntil("ready", 20), HasSubstr("ready"));
  std::this_thread::sleep_for(300ms);
  const auto devices = ListDevices();
  std::system("ip link del v0");
  ASSERT_EQ(devices.at(0).serial, "FAR");
  EXPECT_FALSE(devices.at(0).available);
  EXPECT_THAT(devices.at(0).problem,
              AllOf(HasSubstr("wrong network"), HasSubstr("10.9.9.9"), HasSubstr("192.168.77.1")));
}

TEST(WrongNetwork, IsNamedOnlyWhereUnreachable) {
  const std::vector<NetworkInterface> interfaces = {
      {.name = "lo", .address = "127.0.0.1", .netmask = "255.0.0.0", .loopback = true},
      {.name = "eth0", .address = "192.168.7.3", .netmask = "255.255.255.0"},
      {.name = "eth1", .address = "10.0.4.1", .netmask = "255.255.252.0"}};
  for (const char* reachable : {"127.0.0.5", "192.168.7.200", "10.0.7.254"})
    EXPECT_EQ(WrongNetworkText({.address = reachable, .netmask = "255.255.255.0"}, interfaces), "")
        << reachable;
  for (const char* elsewhere : {"192.168.8.3", "10.0.8.1", "169.254.3.4"})
    EXPECT_THAT(WrongNetworkText({.address = elsewhere, .netmask = "255.255.0.0"}, interfaces),
                AllOf(HasSubstr(elsewhere), HasSubstr("255.255.0.0"), HasSubstr("eth0 has 192.168.7.3"),
                      HasSubstr("eth1 has 10.0.4.1"), Not(HasSubstr("lo has"))));
}

TEST(FrameIds, GapsLateArrivalsAndTheWrapAreToldApart) {
  FrameIdCounter counter;
  for (const std::uint64_t id : {65533u, 65534u, 65535u, 1u, 2u}) counter.Arrived(id);
  EXPECT_EQ(counter.Missing(), 0u) << "0 is no frame number";
  for (const std::uint64_t id : {6u, 4u, 7u}) counter.Arrived(id);
  EXPECT_EQ(counter.Missing(), 2u) << "3 and 5";
  EXPECT_EQ(counter.OutOfOrder(), 1u) << "4 came behind 6";
  counter.ArrivedWithoutId();
  counter.Arrived(9);
  EXPECT_EQ(counter.Missing(), 2u) << "8 came without its number";
}

}  // namespace
}  // namespace ulf::test::aravis_faults_test
