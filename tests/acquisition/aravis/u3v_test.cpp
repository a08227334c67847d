// Tests: acquisition/aravis/aravis_device, acquisition/aravis/aravis_discovery,
// acquisition/aravis/aravis_frames, acquisition/aravis/aravis_stream, acquisition/aravis/aravis_session,
// acquisition/aravis/aravis_usb.
//
// USB3 Vision over its own protocol: Aravis and libusb, both as they are, against a camera that is emulated at
// the level of the kernel's USB interface. What arrives, and what goes wrong with cables, ports and cameras.
#include <gmock/gmock.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/aravis/aravis_discovery.h"
#include "acquisition/device/device.h"
#include "acquisition/device/features.h"
#include "core/base/error.h"
#include "core/image/pixel_format.h"
#include "tests/support/floors.h"
#include "tests/support/loopback_namespace.h"
#include "tests/support/test_paths.h"
#include "tests/support/u3v_camera.h"

namespace ulf {
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

  static double Transport(const Device& device, const std::string& name) {
    for (const auto& [known, value] : device.Statistics().transport)
      if (known == name) return value;
    ADD_FAILURE() << "no counter '" << name << "'";
    return -1;
  }

  static Image Expected(const Frame& frame, const std::string& format, int width, int height, int x, int y) {
    const PixelFormat known = *PixelFormatByName(format);
    const Bytes bytes = EmulatedU3vCamera::Ramp({frame.id, static_cast<std::uint32_t>(width),
                                                 static_cast<std::uint32_t>(height),
                                                 static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                                 known.code});
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
  for (const std::string& uri :
       {list[0].uri, std::string("aravis:U1"), std::string("aravis:Test Optics-U1"), std::string("aravis:")}) {
    const auto device = OpenDriver(uri);
    EXPECT_EQ(device->Info().serial, "U1") << uri;
    EXPECT_EQ(device->Info().model, "Test U3V") << uri;
    EXPECT_EQ(device->Info().bus, "USB3Vision") << uri;
    EXPECT_TRUE(camera.Node().IsClaimed(0) && camera.Node().IsClaimed(2)) << "for control and for streaming";
  }
  EXPECT_THAT(ErrorOf([] { OpenDriver("aravis:U9"); }), AllOf(HasSubstr("U9"), HasSubstr("U1")));
}

TEST_F(U3v, TheCommandListsItAsUsb3Vision) {
  const EmulatedU3vCamera camera;
  const test::CommandResult table = test::RunUlf("devices");
  EXPECT_EQ(table.exit_code, 0) << table.errors;
  EXPECT_THAT(table.output, AllOf(HasSubstr("Test Optics Test U3V (serial U1)"), HasSubstr("USB3Vision"),
                                  HasSubstr("ready")));
  const auto json = nlohmann::json::parse(test::RunUlf("devices --json").output);
  EXPECT_EQ(json["devices"][0]["bus"], "USB3Vision");
  EXPECT_EQ(json["devices"][0]["serial"], "U1");
}

TEST_F(U3v, TwoCamerasAreToldApartAndStreamAtOnce) {
  const EmulatedU3vCamera first({.serial = "A1", .port = 1}), second({.serial = "B2", .port = 2});
  EXPECT_EQ(ListAravisDevices().size(), 2u);
  const auto a = OpenDriver("aravis:A1?roi=64x64+0+0&fps=50"), b = OpenDriver("aravis:B2?roi=96x64+0+0&fps=50");
  a->Start();
  b->Start();
  for (const Frame& frame : Take(*a, 5)) EXPECT_EQ(frame.image.pixels.cols, 64);
  for (const Frame& frame : Take(*b, 5)) EXPECT_EQ(frame.image.pixels.cols, 96);
}

TEST_F(U3v, ACameraThatThisUserMayNotOpenIsListedWithTheRemedy) {
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
  const auto device = OpenDriver("aravis:U1?roi=640x480+32+64&fps=40&exposure_us=2500&gain_db=6&format=Mono8");
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
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].status, FrameStatus::kComplete);
    const Image expected = Expected(frames[i], "Mono8", 1280, 1024, 0, 0);
    EXPECT_EQ(cv::norm(frames[i].image.pixels, expected.pixels, cv::NORM_INF), 0) << frames[i].id;
    const double latency_s = frames[i].host_time_s - frames[i].device_time_s;  // both are this machine's clock
    EXPECT_GT(latency_s, -0.01);
    EXPECT_LT(latency_s, 2);
    if (i > 0) {
      EXPECT_GT(frames[i].device_time_s, frames[i - 1].device_time_s);
    }
  }
  const double periods = static_cast<double>(frames.back().id - frames.front().id);
  EXPECT_NEAR((frames.back().device_time_s - frames.front().device_time_s) / periods, 0.025, 0.01);
  device->Stop();
  EXPECT_GT(Transport(*device, "bytes received"), 20.0 * 1280 * 1024);
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
    const auto device = OpenDriver(std::string(kSmall) + "&chunks=on&exposure_us=3000&gain_db=20&format=" + format);
    device->Start();
    for (Frame frame : Take(*device, 5)) {
      ASSERT_EQ(frame.status, FrameStatus::kComplete) << format;
      ASSERT_GE(frame.id, 1000u) << "the camera's own number";
      frame.id -= 1000;
      EXPECT_DOUBLE_EQ(frame.exposure_s, 1e-6 * (3000 + static_cast<double>(frame.id))) << "each its own";
      EXPECT_NEAR(frame.gain, 10, 1e-9);
      EXPECT_NEAR(frame.device_time_s, frame.host_time_s, 2);
      const Image expected = Expected(frame, format, 320, 240, 16, 8);
      EXPECT_EQ(cv::norm(frame.image.pixels, expected.pixels, cv::NORM_INF), 0) << format;
    }
    EXPECT_THAT(Texts(*device), Not(Contains(HasSubstr("chunk"))));
  }
}

TEST_F(U3v, ACameraThatPromisesChunksAndSendsNoneIsNamed) {
  const EmulatedU3vCamera camera({.fate = [](std::uint64_t) { return U3vFate::kNoChunks; }});
  const auto device = OpenDriver(std::string(kSmall) + "&chunks=on&exposure_us=3000");
  device->Start();
  const auto start = Clock::now();
  std::vector<std::string> said;
  while (SecondsSince(start) < 5 && said.empty()) {
    device->Next(100ms);
    for (std::string& text : Texts(*device)) said.push_back(std::move(text));
  }
  EXPECT_THAT(said, Contains(testing::AnyOf(HasSubstr("contain none"), HasSubstr("wrong size"))));
}

// ---- faults ---------------------------------------------------------------------------------------------

TEST_F(U3v, XUnplug) {
  EmulatedU3vCamera camera;
  const auto device = OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera.Unplug();
  double s = 0;
  fmt::print("LOSS {}", Loss(*device, &s));
  fmt::print(" {}\n", s);
  for (auto& t : Texts(*device)) fmt::print("  {}\n", t);
}
TEST_F(U3v, XUnplugTrigger) {
  EmulatedU3vCamera camera;
  const auto device = OpenDriver(std::string(kSmall)+"&trigger=Line0");
  device->Start();
  device->Next(200ms);
  camera.Unplug();
  double s = 0;
  fmt::print("LOSS {}", Loss(*device, &s));
  fmt::print(" {}\n", s);
  for (auto& t : Texts(*device)) fmt::print("  {}\n", t);
}
TEST_F(U3v, XReplug) {
  EmulatedU3vCamera camera;
  const auto device = OpenDevice(kSmall);
  device->Start();
  Take(*device, 5);
  camera.Unplug();
  std::thread back([&] { std::this_thread::sleep_for(2s); camera.PlugIn(); });
  auto t0 = Clock::now();
  Take(*device, 200);
  back.join();
  fmt::print("back {}\n", SecondsSince(t0));
  for (auto& t : Texts(*device)) fmt::print("  {}\n", t);
}
TEST_F(U3v, XStall) {
  EmulatedU3vCamera camera;
  const auto device = OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera.StallStream();
  double s = 0;
  fmt::print("LOSS {}", Loss(*device, &s));
  fmt::print(" {} {}\n", s, camera.Node().HaltsCleared(EmulatedU3vCamera::kStreamIn));
  for (auto& t : Texts(*device)) fmt::print("  {}\n", t);
}
TEST_F(U3v, XFates) {
  for (auto fate : {U3vFate::kLost, U3vFate::kCut, U3vFate::kNoTrailer, U3vFate::kShortTrailer, U3vFate::kNoLeader}) 
  for (const char* size : {"320x240+0+0", "1280x1024+0+0"}) {
    EmulatedU3vCamera camera({.fate = [fate](std::uint64_t id) { return id % 10 == 5 ? fate : U3vFate::kArrives; }});
    const auto device = OpenDriver(std::string("aravis:U1?fps=40&roi=")+size);
    device->Start();
    auto frames = Take(*device, 40);
    int wrong = 0;
    std::string ids;
    for (auto& f : frames) {
      ids += fmt::format("{}{} ", f.id, f.status == FrameStatus::kComplete ? "" : "!");
      if (f.status == FrameStatus::kComplete) wrong += cv::norm(f.image.pixels, Expected(f, "Mono8", f.image.pixels.cols, f.image.pixels.rows, 0, 0).pixels, cv::NORM_INF) > 0;
    }
    const auto st = device->Statistics();
    fmt::print("FATE {} {}: wrong {} missing {} incomplete {} | {}\n", (int)fate, size, wrong, st.missing, st.incomplete, ids);
    for (auto& [n, v] : st.transport) fmt::print("{} {}, ", n, v);
    fmt::print("\n");
    for (auto& t : Texts(*device)) fmt::print("  {}\n", t);
  }
}
TEST_F(U3v, XControl) {
  for (auto answer : {U3vAnswer::kPending, U3vAnswer::kOtherFirst, U3vAnswer::kSilent, U3vAnswer::kRefuses}) {
    EmulatedU3vCamera camera;
    auto device = OpenDriver(kSmall);
    fmt::print("ANSWER {}\n", (int)answer);
    camera.Answer([=](std::uint64_t a, bool w) { return w && a == EmulatedU3vCamera::kExposure ? answer : U3vAnswer::kAnswers; });
    device.reset();
    auto t0 = Clock::now();
    fmt::print("{}", ErrorOf([&] { device = OpenDriver(std::string(kSmall) + "&exposure_us=700"); }));
    fmt::print(" {} s; {}\n", SecondsSince(t0), camera.RealRegister(EmulatedU3vCamera::kExposure));
  }
  EmulatedU3vCamera camera;
  camera.Answer([=](std::uint64_t, bool) { return U3vAnswer::kSilent; });
  auto t0 = Clock::now();
  fmt::print("{}", ErrorOf([&] { OpenDriver(std::string(kSmall) + "&exposure_us=700"); }));
  fmt::print(" {} s\n", SecondsSince(t0));
}

}  // namespace
}  // namespace ulf
