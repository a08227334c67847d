// Tests: acquisition/aravis/aravis_device, acquisition/aravis/aravis_discovery,
// acquisition/aravis/aravis_frames, acquisition/aravis/aravis_stream, acquisition/aravis/aravis_session,
// acquisition/aravis/aravis_usb.
//
// USB3 Vision over its own protocol: Aravis and libusb, both as they are, against a camera that is
// emulated at the level of the kernel's USB interface. What arrives, and what goes wrong with cables,
// ports and cameras.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/aravis/aravis_usb.h"
#include "acquisition/device/device.h"
#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/frames/pixel_format.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/usb/u3v_camera.h"

namespace ulf::u3v_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::Bytes;
using test::EmulatedU3vCamera;
using test::U3vAnswer;
using test::U3vFate;
using test::U3vFrame;
using test::U3vOptions;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kSmall = "aravis:U1?roi=320x240+16+8&fps=100";

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class U3v : public testing::Test {
 protected:
  void SetUp() override {
    // In a network of its own, so that no GigE Vision camera of the place answers; no matter if not.
    static const auto no_namespace = test::EnterLoopbackNamespace();
    static_cast<void>(no_namespace);
    if (const auto why = test::NoUsbEmulation()) GTEST_SKIP() << *why;
  }

  // The driver alone, without what opens it again.
  static std::unique_ptr<Device> OpenDriver(const std::string& uri) {
    return OpenAravisDevice(DeviceUri::Parse(uri));
  }

  static std::vector<Frame> Take(Device& device, std::size_t count, double patience_s = 20) {
    std::vector<Frame> frames;
    const auto start = Clock::now();
    while (frames.size() < count && SecondsSince(start) < patience_s && !IsOver(device.State()))
      if (auto frame = device.Next(200ms)) frames.push_back(std::move(*frame));
    EXPECT_EQ(frames.size(), count) << device.Info().problem;
    return frames;
  }

  // Until the driver gives up; its reason and how long that took.
  static std::string Loss(Device& device, double* seconds = nullptr, double patience_s = 20) {
    const auto start = Clock::now();
    while (device.State() != DeviceState::kLost && SecondsSince(start) < patience_s) device.Next(50ms);
    if (seconds) *seconds = SecondsSince(start);
    EXPECT_EQ(device.State(), DeviceState::kLost);
    return device.Info().problem;
  }

  static std::string ErrorOf(const std::function<void()>& work) {
    try {
      work();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  static std::vector<std::string> Texts(Device& device) {
    std::vector<std::string> texts;
    for (const DeviceEvent& event : device.TakeEvents()) texts.push_back(event.text);
    return texts;
  }

  static double Transport(const Device& device, TransportFigure figure) {
    if (const auto value = FigureIn(device.Statistics().transport, figure)) return *value;
    ADD_FAILURE() << "no counter '" << Name(figure) << "'";
    return -1;
  }

  static Image Expected(const Frame& frame, const std::string& format, int width, int height, int x, int y) {
    const PixelFormat known = *PixelFormatByName(format);
    const Bytes bytes = EmulatedU3vCamera::Ramp(
        {frame.id, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
         static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), known.code});
    return ImageFromBytes(known, width, height, bytes.data(), bytes.size());
  }
};

// ---- discovery and settings -----------------------------------------------------------------------------

TEST_F(U3v, IsListedAndOpensByEachOfItsNames) {
  const EmulatedU3vCamera camera;
  const auto list = ListAravisDevices();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].maker, "Test Optics");
  EXPECT_EQ(list[0].model, "Test U3V");
  EXPECT_EQ(list[0].serial, "U1");
  EXPECT_EQ(list[0].bus, "USB3Vision");
  EXPECT_TRUE(list[0].available) << list[0].problem;
  for (const std::string& uri : {list[0].uri, std::string("aravis:U1"), std::string("aravis:Test Optics-U1"),
                                 std::string("aravis:")}) {
    const auto device = OpenDriver(uri);
    EXPECT_EQ(device->Info().serial, "U1") << uri;
    EXPECT_EQ(device->Info().model, "Test U3V") << uri;
    EXPECT_EQ(device->Info().bus, "USB3Vision") << uri;
    EXPECT_TRUE(camera.Node().IsClaimed(0) && camera.Node().IsClaimed(2)) << "for control and for streaming";
    EXPECT_FALSE(camera.Node().IsClaimed(1)) << "for events, which the library does not offer";
  }
  EXPECT_THAT(ErrorOf([] { OpenDriver("aravis:U9"); }), AllOf(HasSubstr("U9"), HasSubstr("U1")));
}

// 320x240 pixels of 8 bits at 100 a second are 7.7 MB a second.
TEST_F(U3v, CheckNamesNeighboursOnTheHubAndTheirShare) {
  const EmulatedU3vCamera camera({.port = "3.1"}), beside({.model = "Second", .serial = "B2", .port = "3.2"}),
      elsewhere({.model = "Third", .serial = "C3", .port = "2"});
  const auto run = test::RunUlf(std::string("devices --seconds 0.5 --json --check '") + kSmall + "'");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  std::string value, advice;
  const auto report = JsonFromText(run.output);
  for (const auto& fact : report["facts"])
    if (fact["name"] == "beside it") value = fact["value"], advice = fact["advice"];
  EXPECT_THAT(
      value,
      AllOf(HasSubstr("Test Optics Third (port 2-2, 5000 Mbit/s) at the same controller"),
            HasSubstr("Test Optics Second (port 2-3.2, 5000 Mbit/s) behind the same hub 2-3"),
            HasSubstr("carries about 400 MB/s for all, this camera is set to 7.7, the others can take 400")));
  ASSERT_FALSE(value.empty()) << run.output;
  EXPECT_THAT(advice, AllOf(HasSubstr("a port of the computer for each"), HasSubstr("throughput_limit")));
}

TEST_F(U3v, CheckNamesTheRateOfASlowCamera) {
  const EmulatedU3vCamera camera;
  const std::string uri = "aravis:U1?roi=320x240+16+8&fps=60&exposure_us=50000";
  const auto run = test::RunUlf("devices --seconds 3 --json --check '" + uri + "'");
  const auto report = JsonFromText(run.output);
  ASSERT_TRUE(report["remedy"].is_string()) << run.output;
  const std::string remedy = report["remedy"];
  ASSERT_TRUE(remedy.starts_with("fps=")) << remedy;
  EXPECT_NEAR(std::stod(remedy.substr(4)), 20, 1) << "and not less";
  EXPECT_THAT(std::string(report["verdict"]),
              AllOf(HasSubstr("the camera is the limit, not the link"), HasSubstr("exposure time")));
}

TEST_F(U3v, TheCommandListsItAsUsb3Vision) {
  const EmulatedU3vCamera camera;
  const test::CommandResult table = test::RunUlf("devices");
  EXPECT_EQ(table.exit_code, 0) << table.errors;
  EXPECT_THAT(table.output, AllOf(HasSubstr("Test Optics Test U3V (serial U1)"), HasSubstr("USB3Vision"),
                                  HasSubstr("ready")));
  const auto json = JsonFromText(test::RunUlf("devices --json").output);
  EXPECT_EQ(json["devices"][0]["bus"], "USB3Vision");
  EXPECT_EQ(json["devices"][0]["serial"], "U1");
}

// In a process of its own, as people use it.
TEST_F(U3v, TheCommandsShowItsSettingsAndRecordFromIt) {
  const EmulatedU3vCamera camera;
  const test::CommandResult features = test::RunUlf("features aravis:U1");
  EXPECT_EQ(features.exit_code, 0) << features.errors;
  EXPECT_THAT(features.output, AllOf(HasSubstr("ExposureTime"), HasSubstr("DeviceLinkThroughputLimit")));
  const test::ScratchFolder folder;
  const std::string session = folder / "session";
  const test::CommandResult record =
      test::RunUlf("record 'aravis:U1?roi=320x240+16+8&fps=50&format=Mono8' --frames 10 -o " + session);
  EXPECT_EQ(record.exit_code, 0) << record.errors;
  const auto replay = OpenDevice("replay:" + session);
  replay->Start();
  std::size_t frames = 0;
  while (const auto frame = replay->Next(5s)) {
    ++frames;
    const Image expected = Expected(*frame, "Mono8", 320, 240, 16, 8);
    EXPECT_EQ(cv::norm(frame->image.pixels, expected.pixels, cv::NORM_INF), 0) << frame->id;
  }
  EXPECT_EQ(frames, 10u);
}

TEST_F(U3v, TwoCamerasAreToldApartAndStreamAtOnce) {
  const EmulatedU3vCamera first({.serial = "A1", .port = "1"}), second({.serial = "B2", .port = "2"});
  EXPECT_EQ(ListAravisDevices().size(), 2u);
  const auto a = OpenDriver("aravis:A1?roi=64x64+0+0&fps=50"),
             b = OpenDriver("aravis:B2?roi=96x64+0+0&fps=50");
  a->Start();
  b->Start();
  for (const Frame& frame : Take(*a, 5)) EXPECT_EQ(frame.image.pixels.cols, 64);
  for (const Frame& frame : Take(*b, 5)) EXPECT_EQ(frame.image.pixels.cols, 96);
}

TEST_F(U3v, ListsACameraWithoutPermissionAndTheRemedy) {
  const EmulatedU3vCamera camera;
  camera.Node().Refuse(EACCES);
  const auto list = ListAravisDevices();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_FALSE(list[0].available);
  EXPECT_EQ(list[0].serial, "U1");
  EXPECT_EQ(list[0].bus, "USB3Vision");
  EXPECT_THAT(list[0].problem, AllOf(HasSubstr("/dev/bus/usb/002/"), HasSubstr("70-ulf-cameras.rules")));
  EXPECT_THAT(ErrorOf([] { OpenDriver("aravis:U1"); }), HasSubstr("may not be opened by this user"));
}

TEST_F(U3v, ACameraThatAnotherProgramHasClaimedIsAnError) {
  const EmulatedU3vCamera camera;
  const auto device = OpenDriver("aravis:U1");
  EXPECT_THAT(ErrorOf([] { OpenDriver("aravis:U1"); }),
              AllOf(HasSubstr("aravis:U1"), HasSubstr("another program")));
}

TEST_F(U3v, ADescriptionThatIsNotZippedIsReadToo) {
  const EmulatedU3vCamera camera({.zipped = false, .event_interface = false});
  const auto device = OpenDriver(kSmall);
  device->Start();
  EXPECT_EQ(Take(*device, 3).size(), 3u);
}

TEST_F(U3v, FeaturesAreReadAndWritten) {
  const EmulatedU3vCamera camera;
  const auto features = OpenFeatures("aravis:U1");
  const auto value_of = [&](const std::string& name) { return features->Find(name).value().value; };
  EXPECT_EQ(value_of("DeviceSerialNumber"), "U1");
  EXPECT_EQ(value_of("SensorWidth"), "1280");
  EXPECT_EQ(value_of("PixelFormat"), "Mono8");
  features->Set("ExposureTime", "1234.5");
  features->Set("DeviceLinkThroughputLimit", "20000000");
  features->Set("TriggerMode", "On");
  EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kExposure), 1234.5);
  EXPECT_EQ(camera.Register(EmulatedU3vCamera::kThroughputLimit), 20'000'000u);
  EXPECT_EQ(camera.Register(EmulatedU3vCamera::kTriggerMode), 1u);
  EXPECT_EQ(value_of("ExposureTime"), "1234.5");
}

TEST_F(U3v, TheUrisSettingsReachTheCamera) {
  const EmulatedU3vCamera camera;
  const auto device =
      OpenDriver("aravis:U1?roi=640x480+32+64&fps=40&exposure_us=2500&gain_db=6&format=Mono8");
  EXPECT_EQ(camera.Register(EmulatedU3vCamera::kWidth), 640u);
  EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kExposure), 2500);
  EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kGain), 6);
  EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kFrameRate), 40);
  device->Start();
  for (const Frame& frame : Take(*device, 3)) {
    EXPECT_DOUBLE_EQ(frame.exposure_s, 0.0025);
    EXPECT_NEAR(frame.gain, 1.9953, 1e-3);
  }
  EXPECT_THAT(Texts(*device), Not(Contains(HasSubstr("changed"))));
}

// ---- frames ---------------------------------------------------------------------------------------------

TEST_F(U3v, EveryFormatArrivesPixelForPixel) {
  const EmulatedU3vCamera camera;
  for (const char* format : {"Mono8", "BayerRG8", "Mono12", "Mono10p", "Mono12p", "BayerRG12p"}) {
    const auto device = OpenDriver(std::string(kSmall) + "&format=" + format);
    device->Start();
    const auto frames = Take(*device, 5);
    for (const Frame& frame : frames) {
      ASSERT_EQ(frame.status, FrameStatus::kComplete) << format;
      const Image expected = Expected(frame, format, 320, 240, 16, 8);
      ASSERT_EQ(frame.image.pixels.type(), expected.pixels.type()) << format;
      ASSERT_EQ(frame.image.pixels.size(), expected.pixels.size()) << format;
      EXPECT_EQ(cv::norm(frame.image.pixels, expected.pixels, cv::NORM_INF), 0) << format << frame.id;
      EXPECT_EQ(frame.image.mosaic, PixelFormatByName(format)->mosaic) << format;
    }
    EXPECT_EQ(device->Statistics().incomplete, 0u) << format;
  }
}

// A megabyte and more travels in several transfers.
TEST_F(U3v, LargeFramesArriveWholeWithTheirNumbersAndTimes) {
  const EmulatedU3vCamera camera;
  const auto device = OpenDriver("aravis:U1?fps=40&format=Mono8&queue=30");
  device->Start();
  const auto frames = Take(*device, 20);
  ASSERT_EQ(frames.size(), 20u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].status, FrameStatus::kComplete);
    const Image expected = Expected(frames[i], "Mono8", 1280, 1024, 0, 0);
    EXPECT_EQ(cv::norm(frames[i].image.pixels, expected.pixels, cv::NORM_INF), 0) << frames[i].id;
    const double latency_s =
        frames[i].host_time_s - frames[i].device_time_s;  // both are this machine's clock
    EXPECT_GT(latency_s, -0.01);
    EXPECT_LT(latency_s, 2);
    if (i > 0) {
      EXPECT_GT(frames[i].device_time_s, frames[i - 1].device_time_s);
    }
  }
  const double periods = static_cast<double>(frames.back().id - frames.front().id);
  EXPECT_NEAR((frames.back().device_time_s - frames.front().device_time_s) / periods, 0.025, 0.01);
  device->Stop();
  EXPECT_GT(Transport(*device, TransportFigure::kBytesReceived), 20.0 * 1280 * 1024);
  // One transfer at a time, far from the kernel's limit on USB memory.
  EXPECT_LE(camera.Node().MostMemory(), 2 << 20);
}

TEST_F(U3v, StopsAndStartsAgain) {
  const EmulatedU3vCamera camera;
  const auto device = OpenDriver(kSmall);
  for (int turn = 0; turn < 3; ++turn) {
    device->Start();
    EXPECT_EQ(Take(*device, 5).size(), 5u) << turn;
    EXPECT_TRUE(camera.IsAcquiring());
    device->Stop();
    EXPECT_FALSE(camera.IsAcquiring());
    EXPECT_EQ(device->State(), DeviceState::kConnected);
  }
}

TEST_F(U3v, ASoftwareTriggerGivesOneFrameForEachCall) {
  const EmulatedU3vCamera camera;
  const auto device = OpenDriver(std::string(kSmall) + "&trigger=software");
  device->Start();
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(camera.Exposed(), 0u) << "none without a trigger";
  for (std::uint64_t i = 0; i < 5; ++i) {
    const auto frames = Take(*device, 1);
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(frames[0].id, i);
    EXPECT_EQ(camera.Exposed(), i + 1);
  }
}

TEST_F(U3v, ChunkDataReachTheFrames) {
  const EmulatedU3vCamera camera;
  for (const char* format : {"Mono8", "Mono12p"}) {
    const auto device =
        OpenDriver(std::string(kSmall) + "&chunks=on&exposure_us=3000&gain_db=20&format=" + format);
    device->Start();
    for (Frame frame : Take(*device, 5)) {
      ASSERT_EQ(frame.status, FrameStatus::kComplete) << format;
      ASSERT_GE(frame.id, 1000u) << "the camera's own number";
      frame.id -= 1000;
      EXPECT_DOUBLE_EQ(frame.exposure_s, 1e-6 * (3000 + static_cast<double>(frame.id))) << "each its own";
      EXPECT_NEAR(frame.gain, std::pow(10, (20 + 0.5 * static_cast<double>(frame.id % 4)) / 20), 1e-9);
      EXPECT_NEAR(frame.device_time_s, frame.host_time_s, 2);
      const Image expected = Expected(frame, format, 320, 240, 16, 8);
      EXPECT_EQ(cv::norm(frame.image.pixels, expected.pixels, cv::NORM_INF), 0) << format;
    }
    EXPECT_THAT(Texts(*device), Not(Contains(HasSubstr("chunk"))));
  }
}

// Its frames are shorter than it agreed, so that the library takes none of them for whole: the stream
// begins anew without.
TEST_F(U3v, CameraWithoutPromisedChunksIsNamedAndUsed) {
  const EmulatedU3vCamera camera({.fate = [](std::uint64_t) { return U3vFate::kNoChunks; }});
  const auto device = OpenDriver(std::string(kSmall) + "&chunks=on&exposure_us=3000&gain_db=6&queue=30");
  device->Start();
  const auto start = Clock::now();
  std::vector<Frame> whole;
  while (SecondsSince(start) < 20 && whole.size() < 5 && device->State() == DeviceState::kStreaming)
    if (auto frame = device->Next(200ms); frame && frame->status == FrameStatus::kComplete)
      whole.push_back(std::move(*frame));
  ASSERT_EQ(whole.size(), 5u) << device->Info().problem;
  for (const Frame& frame : whole) {
    EXPECT_DOUBLE_EQ(frame.exposure_s, 0.003);
    EXPECT_NEAR(frame.gain, 1.9953, 1e-3);
    EXPECT_FALSE(frame.told_id);
    const Image expected = Expected(frame, "Mono8", 320, 240, 16, 8);
    EXPECT_EQ(cv::norm(frame.image.pixels, expected.pixels, cv::NORM_INF), 0) << frame.id;
  }
  const std::uint64_t incomplete = device->Statistics().incomplete;
  EXPECT_GE(incomplete, 3u) << "those before are not passed over in silence";
  EXPECT_LT(incomplete, 10u);
  EXPECT_EQ(device->Statistics().out_of_order, 0u) << "its numbers begin anew";
  EXPECT_THAT(Texts(*device),
              Contains(AllOf(HasSubstr("chunk data are switched on, but none"), HasSubstr("chunks=off"))));
  EXPECT_EQ(camera.Register(EmulatedU3vCamera::kChunkMode), 0u);
  device->Stop();
  device->Start();
  for (const Frame& frame : Take(*device, 3)) EXPECT_EQ(frame.status, FrameStatus::kComplete);
}

// A frame that was damaged on its way says nothing about chunk data.
TEST_F(U3v, ABrokenFrameAmongWholeOnesLeavesChunkDataOn) {
  const EmulatedU3vCamera camera(
      {.fate = [](std::uint64_t id) { return id == 0 || id > 3 ? U3vFate::kArrives : U3vFate::kCut; }});
  const auto device = OpenDriver(std::string(kSmall) + "&chunks=on&queue=30");
  device->Start();
  Take(*device, 8);
  EXPECT_EQ(camera.Register(EmulatedU3vCamera::kChunkMode), 1u);
  EXPECT_THAT(Texts(*device), Not(Contains(HasSubstr("switched on, but"))));
}

// ---- faults ---------------------------------------------------------------------------------------------

TEST_F(U3v, APulledCableIsKnownAtOnce) {
  for (const char* trigger : {"", "&trigger=Line0"}) {  // also while it waits, when nothing is due
    EmulatedU3vCamera camera;
    const auto device = OpenDriver(kSmall + std::string(trigger));
    device->Start();
    if (*trigger) {
      EXPECT_FALSE(device->Next(200ms));
    } else {
      Take(*device, 5);
    }
    camera.Unplug();
    double seconds = 0;
    EXPECT_THAT(Loss(*device, &seconds), AllOf(HasSubstr("no longer on the bus"), HasSubstr("cable")));
    EXPECT_LT(seconds, 2);
    const auto stopped = Clock::now();
    device->Stop();
    EXPECT_LT(SecondsSince(stopped), 2) << "no call waits for a camera that is gone";
    EXPECT_THAT(ErrorOf([&] { device->Start(); }), HasSubstr("open the device again"));
  }
}

// The library does not outlive the begin of a stream whose camera it cannot read.
TEST_F(U3v, CablePulledBeforeTheStreamIsAnError) {
  EmulatedU3vCamera camera;
  const auto opened = OpenDriver(kSmall);
  camera.Unplug();
  EXPECT_THAT(ErrorOf([&] { opened->Start(); }), AllOf(HasSubstr("aravis:U1"), HasSubstr("cable")));
  camera.PlugIn();
  const auto stopped = OpenDriver(kSmall);
  stopped->Start();
  Take(*stopped, 3);
  stopped->Stop();
  camera.Unplug();
  EXPECT_THAT(ErrorOf([&] { stopped->Start(); }), AllOf(HasSubstr("aravis:U1"), HasSubstr("cable")));
}

TEST_F(U3v, ACameraThatDescribesItsStreamWronglyIsAnError) {
  const EmulatedU3vCamera camera({.alignment_bits = 31});
  const auto device = OpenDriver(kSmall);
  EXPECT_THAT(ErrorOf([&] { device->Start(); }), AllOf(HasSubstr("aravis:U1"), HasSubstr("2^31")));
}

TEST_F(U3v, StreamsOnWithItsSettingsWhenReplugged) {
  EmulatedU3vCamera camera;
  const auto device = OpenDevice("aravis:U1?roi=320x240+16+8&fps=50&exposure_us=700");
  device->Start();
  Take(*device, 5);
  camera.Unplug();
  EXPECT_EQ(camera.RealRegister(EmulatedU3vCamera::kExposure), 5000) << "it forgot what it was set to";
  std::this_thread::sleep_for(500ms);
  camera.PlugIn();
  const auto frames = Take(*device, 20, 30);
  ASSERT_EQ(frames.size(), 20u);
  const Frame& last = frames.back();
  EXPECT_DOUBLE_EQ(last.exposure_s, 0.0007);
  EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kExposure), 700);
  EXPECT_EQ(cv::norm(last.image.pixels, Expected(last, "Mono8", 320, 240, 16, 8).pixels, cv::NORM_INF), 0);
  EXPECT_THAT(Texts(*device),
              AllOf(Contains(HasSubstr("no longer on the bus")), Contains(HasSubstr("streams again"))));
}

TEST_F(U3v, UnpluggingOneCameraLeavesTheOtherStreaming) {
  EmulatedU3vCamera first({.serial = "A1", .port = "1"}), second({.serial = "B2", .port = "2"});
  const auto a = OpenDriver("aravis:A1?roi=64x64+0+0&fps=50"),
             b = OpenDriver("aravis:B2?roi=96x64+0+0&fps=50");
  a->Start();
  b->Start();
  Take(*b, 3);
  first.Unplug();
  Loss(*a);
  EXPECT_EQ(Take(*b, 30).size(), 30u);
  EXPECT_EQ(b->State(), DeviceState::kStreaming);
}

// The library never clears a halted endpoint while it streams. Opening the camera anew does.
TEST_F(U3v, AStalledStreamIsLostAndOpenedAnew) {
  EmulatedU3vCamera camera;
  {
    const auto driver = OpenDriver(kSmall);
    driver->Start();
    Take(*driver, 5);
    camera.StallStream();
    EXPECT_THAT(Loss(*driver), HasSubstr("although the camera answers: its stream has stopped"));
    EXPECT_THAT(Texts(*driver), Contains(HasSubstr("no frame for 0.5 s")));
  }
  const auto device = OpenDevice(kSmall);
  device->Start();
  Take(*device, 5);
  const std::size_t cleared = camera.Node().HaltsCleared(EmulatedU3vCamera::kStreamIn);
  camera.StallStream();
  EXPECT_EQ(Take(*device, 20, 30).size(), 20u);
  EXPECT_GT(camera.Node().HaltsCleared(EmulatedU3vCamera::kStreamIn), cleared);
}

TEST_F(U3v, ACameraThatFallsSilentAltogetherIsSaidTo) {
  EmulatedU3vCamera camera;
  const auto device = OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera.HoldBack(true);
  camera.Answer([](std::uint64_t, bool) { return U3vAnswer::kSilent; });
  EXPECT_THAT(Loss(*device), HasSubstr("the camera does not answer; check power and cable"));
}

TEST_F(U3v, AShortPauseIsNoLoss) {
  EmulatedU3vCamera camera;
  const auto device = OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera.HoldBack(true);
  const auto start = Clock::now();
  while (SecondsSince(start) < 1.2) device->Next(50ms);
  camera.HoldBack(false);
  EXPECT_EQ(Take(*device, 10).size(), 10u);
  EXPECT_THAT(Texts(*device),
              AllOf(Contains(HasSubstr("no frame for")), Contains(HasSubstr("frames come again"))));
}

// Whatever of a frame is missing: it is never taken for a whole one, the frames around it are as they were,
// and the counts say what happened.
TEST_F(U3v, DamagedFramesAreCountedAndNeverUsed) {
  struct Case {
    U3vFate fate;
    const char* name;
    bool arrives;     // at all
    bool incomplete;  // if so
    int width, height;
  };
  for (const Case& one : {Case{U3vFate::kLost, "lost", false, false, 320, 240},
                          Case{U3vFate::kCut, "cut", true, true, 320, 240},
                          Case{U3vFate::kCut, "cut in the first of two transfers", true, true, 1280, 1024},
                          Case{U3vFate::kNoTrailer, "no trailer", true, true, 320, 240},
                          Case{U3vFate::kNoTrailer, "no trailer after two transfers", true, true, 1280, 1024},
                          Case{U3vFate::kShortTrailer, "short trailer", true, false, 320, 240},  // all pixels
                          // The library does not look at the status.
                          Case{U3vFate::kBadTrailer, "trailer of an error", true, false, 320, 240},
                          Case{U3vFate::kNoLeader, "no leader", false, false, 320, 240}}) {
    const EmulatedU3vCamera camera(
        {.fate = [&](std::uint64_t id) { return id % 5 == 3 ? one.fate : U3vFate::kArrives; }});
    const auto device = OpenDriver(
        fmt::format("aravis:U1?fps=40&queue=40&format=Mono8&roi={}x{}+0+0", one.width, one.height));
    device->Start();
    std::uint64_t damaged = 0, missing = 0, before = 0;
    for (const Frame& frame : Take(*device, 16)) {
      if (frame.id > before + 1) missing += frame.id - before - 1;
      before = frame.id;
      if (frame.id % 5 == 3) ++damaged;
      ASSERT_EQ(frame.status == FrameStatus::kIncomplete, frame.id % 5 == 3 && one.incomplete)
          << one.name << ", frame " << frame.id;
      if (frame.status == FrameStatus::kIncomplete) continue;
      const Image expected = Expected(frame, "Mono8", one.width, one.height, 0, 0);
      EXPECT_EQ(cv::norm(frame.image.pixels, expected.pixels, cv::NORM_INF), 0) << one.name << frame.id;
    }
    EXPECT_GE(one.arrives ? damaged : missing, 3u) << one.name;
    const DeviceStatistics statistics = device->Statistics();
    EXPECT_GE(statistics.missing, missing) << one.name;
    EXPECT_EQ(statistics.missing > 0, !one.arrives) << one.name;
    EXPECT_GE(statistics.incomplete, one.incomplete ? damaged : 0) << one.name;
    EXPECT_EQ(statistics.incomplete > 0, one.incomplete) << one.name;
    if (one.incomplete) {
      EXPECT_THAT(Texts(*device), Contains(HasSubstr("arrived incomplete"))) << one.name;
    }
  }
}

TEST_F(U3v, ASlowReaderLosesTheOldestFramesAndIsTold) {
  const EmulatedU3vCamera camera;
  const auto device = OpenDriver("aravis:U1?roi=64x64+0+0&fps=200&queue=2");
  device->Start();
  Take(*device, 1);
  std::this_thread::sleep_for(500ms);
  const auto frame = device->Next(1s);
  ASSERT_TRUE(frame);
  EXPECT_GT(frame->id, 50u);
  EXPECT_GT(device->Statistics().dropped, 50u);
  EXPECT_EQ(device->Statistics().incomplete, 0u);
}

// ---- the control channel --------------------------------------------------------------------------------

TEST_F(U3v, AnswersThatComeLateOrAmongOthersAreTaken) {
  for (const U3vAnswer how : {U3vAnswer::kPending, U3vAnswer::kOtherFirst}) {
    EmulatedU3vCamera camera;
    camera.Answer([how](std::uint64_t address, bool write) {
      return write && address == EmulatedU3vCamera::kExposure ? how : U3vAnswer::kAnswers;
    });
    const auto device = OpenDriver(kSmall + std::string("&exposure_us=700"));
    EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kExposure), 700);
    device->Start();
    EXPECT_EQ(Take(*device, 3).size(), 3u);
  }
}

TEST_F(U3v, RefusedOrUnansweredSettingIsANamedError) {
  EmulatedU3vCamera camera;
  for (const auto& [how, words] :
       {std::pair(U3vAnswer::kSilent, "timeout"), std::pair(U3vAnswer::kRefuses, "access-denied")}) {
    camera.Answer([how = how](std::uint64_t address, bool write) {
      return write && address == EmulatedU3vCamera::kExposure ? how : U3vAnswer::kAnswers;
    });
    const auto start = Clock::now();
    EXPECT_THAT(ErrorOf([] { OpenDriver(kSmall + std::string("&exposure_us=700")); }),
                AllOf(HasSubstr("aravis:U1"), HasSubstr("exposure"), HasSubstr(words)));
    EXPECT_LT(SecondsSince(start), 6);
  }
}

TEST_F(U3v, UnresponsiveCameraIsAnErrorWithTheRemedy) {
  const EmulatedU3vCamera camera({.answer = [](std::uint64_t, bool) { return U3vAnswer::kSilent; }});
  const auto start = Clock::now();
  EXPECT_THAT(ErrorOf([] { OpenDriver(kSmall); }),
              AllOf(HasSubstr("aravis:U1"), HasSubstr("answers no request"), HasSubstr("plug it in again")));
  EXPECT_LT(SecondsSince(start), 10);
}

// One answer in seven does not come: each request is made again.
TEST_F(U3v, LostAnswersAreAskedForAgain) {
  int count = 0;
  const EmulatedU3vCamera camera({.answer = [&count](std::uint64_t, bool) {
    return ++count % 7 == 0 ? U3vAnswer::kSilent : U3vAnswer::kAnswers;
  }});
  const auto device = OpenDriver(kSmall + std::string("&exposure_us=700"));
  EXPECT_DOUBLE_EQ(camera.RealRegister(EmulatedU3vCamera::kExposure), 700);
  EXPECT_GE(camera.Requests(), 70u) << "so that ten were lost";
}

// ---- the port -------------------------------------------------------------------------------------------

TEST_F(U3v, APortOfUsb2IsSaidWithWhatItCarries) {
  const EmulatedU3vCamera camera({.megabits = 480});
  EXPECT_EQ(camera.Register(EmulatedU3vCamera::kSpeed), 4u) << "what the camera itself says of it";
  const auto list = ListAravisDevices();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_TRUE(list[0].available);
  EXPECT_THAT(list[0].remark, AllOf(HasSubstr("USB 2"), HasSubstr("480 Mbit/s"), HasSubstr("USB 3 port")));
  EXPECT_THAT(test::RunUlf("devices").output, HasSubstr("ready, but connected at the speed of USB 2"));
  const auto device = OpenDriver("aravis:U1?fps=100&format=Mono8&queue=40");
  EXPECT_THAT(Texts(*device), Contains(AllOf(HasSubstr("the camera is connected at the speed of USB 2"),
                                             HasSubstr("port 2-1"), HasSubstr("30.5 frames of this size"))));
  device->Start();
  const auto frames = Take(*device, 20);
  const double fps = 19 / (frames.back().device_time_s - frames.front().device_time_s);
  EXPECT_LT(fps, 32) << "and so it is";
}

TEST_F(U3v, APortOfUsb3NeedsNoRemark) {
  const EmulatedU3vCamera camera;
  EXPECT_EQ(ListAravisDevices().at(0).remark, "");
  EXPECT_THAT(Texts(*OpenDriver(kSmall)), Not(Contains(HasSubstr("USB"))));
}

TEST(AravisUsb, PlacesAreReadFromTheSystem) {
  const test::ScratchFolder sysfs;
  const auto write = [&](const std::string& file, const std::string& text) {
    std::filesystem::create_directories((sysfs / file).parent_path());
    std::ofstream(sysfs / file) << text << "\n";
  };
  for (const auto& [port, serial, speed] :
       {std::tuple("4-2", "S2", "480"), std::tuple("2-1.4", "S1", "10000")}) {
    const std::string device = port;
    write(device + "/manufacturer", "Maker");
    write(device + "/product", "Model");
    write(device + "/serial", serial);
    write(device + "/busnum", "2");
    write(device + "/devnum", "99");
    write(device + "/speed", speed);
    for (const char* interface : {":1.0", ":1.1"}) {
      write(device + interface + "/bInterfaceClass", "ef");
      write(device + interface + "/bInterfaceSubClass", "05");
      write(device + interface + "/bInterfaceProtocol", "00");
    }
  }
  write("3-1/serial", "KEYBOARD");
  write("3-1:1.0/bInterfaceClass", "03");
  const auto places = UsbCameraPlaces(sysfs.path());
  ASSERT_EQ(places.size(), 2u) << "each once, and no keyboard";
  EXPECT_EQ(places[0].serial, "S1");
  EXPECT_EQ(places[0].megabits, 10000);
  EXPECT_EQ(places[1].port, "4-2");
  EXPECT_EQ(places[1].megabits, 480);
  EXPECT_EQ(places[1].node, "/dev/bus/usb/002/099");
  EXPECT_EQ(places[1].open_error, ENOENT);
  EXPECT_EQ(SlowUsbText(places[0], 1000), "");
  EXPECT_THAT(SlowUsbText(places[1], 4'000'000), AllOf(HasSubstr("port 4-2"), HasSubstr(" 10 frames")));
  EXPECT_DOUBLE_EQ(UsbBytesPerSecond(5000), 400e6);
  EXPECT_EQ(UsbBytesPerSecond(0), 0);
}

TEST(AravisUsb, NeighboursShareTheSameBus) {
  const test::ScratchFolder sysfs;
  for (const auto& [port, product, speed, klass] :
       {std::tuple("2-1", "Hub", "5000", "09"), std::tuple("2-1.1", "Camera", "5000", "ef"),
        std::tuple("2-1.2", "Hub", "5000", "09"), std::tuple("2-1.2.4", "Other camera", "5000", "ef"),
        std::tuple("2-1.12", "Grabber", "5000", "00"), std::tuple("2-3", "Disk", "10000", "00"),
        std::tuple("2-4", "Mouse", "1.5", "00"), std::tuple("1-1.1", "Webcam", "480", "ef"),
        std::tuple("usb2", "Root hub", "10000", "09")}) {
    std::filesystem::create_directories(sysfs / port);
    for (const auto& [name, text] : {std::pair("manufacturer", "Maker"), std::pair("product", product),
                                     std::pair("speed", speed), std::pair("bDeviceClass", klass)})
      std::ofstream(sysfs / (std::string(port) + "/" + name)) << text << "\n";
  }
  std::filesystem::create_directories(sysfs / "2-1.1:1.0");
  const auto of = [&](const std::string& port) {
    std::vector<std::string> texts;
    for (const UsbNeighbour& each : UsbNeighboursOf(port, sysfs.path()))
      texts.push_back(
          fmt::format("{} at {}, hub '{}' {}", each.name, each.port, each.hub, each.hub_megabits));
    return texts;
  };
  EXPECT_THAT(of("2-1.1"), testing::ElementsAre("Maker Grabber at 2-1.12, hub '2-1' 5000",
                                                "Maker Other camera at 2-1.2.4, hub '2-1' 5000",
                                                "Maker Disk at 2-3, hub '' 0"));
  EXPECT_THAT(of("2-3"),
              testing::ElementsAre("Maker Camera at 2-1.1, hub '' 0", "Maker Grabber at 2-1.12, hub '' 0",
                                   "Maker Other camera at 2-1.2.4, hub '' 0"));
  EXPECT_THAT(of("1-1.1"), testing::IsEmpty());
  EXPECT_THAT(of(""), testing::IsEmpty());
}

TEST(AravisUsb, NameTheHolderOfABusyCamera) {
  const test::ScratchFolder folder;
  const std::string node = folder / "node";
  std::ofstream(node) << "x";
  const test::ChildProcess holder({"/bin/sh", "-c", "exec sleep 60 < " + node});
  UsbCameraPlace place;
  place.node = node;
  std::string hint;
  for (const auto start = Clock::now(); SecondsSince(start) < 10 && hint.find("sleep") == std::string::npos;)
    hint = UsbOpenHint("Failed to claim: LIBUSB_ERROR_BUSY", {place});
  EXPECT_THAT(hint,
              AllOf(HasSubstr("another program uses this camera: sleep (process "), HasSubstr("close it")));
  EXPECT_EQ(UsbOpenHint("Device not found", {place}), "");
}

}  // namespace
}  // namespace ulf::u3v_test
