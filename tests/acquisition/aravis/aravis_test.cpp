// Tests: acquisition/aravis/aravis_device, acquisition/aravis/aravis_discovery,
// acquisition/aravis/aravis_frames, acquisition/aravis/aravis_stream, acquisition/aravis/aravis_session.
//
// The Aravis device against Aravis's own fake GigE Vision camera in a process of its own, in a network of its
// own.
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "acquisition/device/device.h"
#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"

namespace ulf::aravis_test {
namespace {

using namespace std::chrono_literals;
using test::Clock;
using test::SecondsSince;
using test::Take;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kSmall = "aravis:127.0.0.1?roi=320x240+0+0&fps=50";

class AravisDevice : public test::CameraInNamespace {};

std::string ErrorOf(const std::string& uri) {
  try {
    OpenDevice(uri)->Start();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << uri << ": no error";
  return "";
}

TEST_F(AravisDevice, FramesArriveWithTheirNumbersAndTimes) {
  StartCamera("T7");
  const auto device = OpenDevice(kSmall + std::string("&format=Mono8&exposure_us=2500"));
  EXPECT_TRUE(device->IsLive());
  EXPECT_EQ(device->Info().serial, "T7");
  EXPECT_EQ(device->Info().bus, "GigEVision");
  EXPECT_FALSE(device->Info().maker.empty());
  device->Start();
  const auto frames = Take(*device, 40);
  ASSERT_EQ(frames.size(), 40u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].status, FrameStatus::kComplete);
    EXPECT_DOUBLE_EQ(frames[i].exposure_s, 0.0025);
    EXPECT_DOUBLE_EQ(frames[i].gain, 1) << "this camera's gain is a number without a unit";
    const double latency_s =
        frames[i].host_time_s - frames[i].device_time_s;  // both are this machine's clock
    EXPECT_GT(latency_s, -0.1);
    EXPECT_LT(latency_s, 2);
    if (i > 0) {
      EXPECT_GT(frames[i].device_time_s, frames[i - 1].device_time_s);
    }
  }
  const double period_s = (frames.back().device_time_s - frames.front().device_time_s) / 39;
  EXPECT_NEAR(period_s, 0.02, 0.015) << "the frame rate acts";
  const DeviceStatistics statistics = device->Statistics();
  EXPECT_EQ(statistics.delivered, 40u);
  EXPECT_EQ(statistics.incomplete, 0u);
  device->Stop();
  EXPECT_FALSE(device->Next(0ms) && device->Next(0ms) && device->Next(0ms) && device->Next(0ms) &&
               device->Next(0ms))
      << "a stopped device hands out at most what was queued";
  device->Start();  // and again
  EXPECT_EQ(Take(*device, 3).size(), 3u);
}

// The fake camera starts counting at 65401: 200 frames lead over the 16-bit wrap.
TEST_F(AravisDevice, NumbersWrapWithoutAGap) {
  StartCamera();
  const auto device = OpenDevice("aravis:127.0.0.1?roi=64x64+0+0&fps=200&format=Mono8&queue=64");
  device->Start();
  const auto frames = Take(*device, 200);
  ASSERT_EQ(frames.size(), 200u);
  EXPECT_GT(frames.front().id, 60000u);
  EXPECT_LT(frames.back().id, 1000u);
  for (const Frame& frame : frames) EXPECT_EQ(frame.status, FrameStatus::kComplete) << frame.id;
  EXPECT_LE(device->Statistics().missing, 20u) << "a wrap taken for a gap would count tens of thousands";
}

TEST_F(AravisDevice, PixelsAreWhereTheCameraPutThem) {
  StartCamera();
  constexpr int kWidth = 320, kHeight = 200, kLeft = 16, kTop = 8;
  const std::string roi =
      fmt::format("aravis:127.0.0.1?roi={}x{}+{}+{}&fps=50", kWidth, kHeight, kLeft, kTop);
  for (const char* format : {"Mono8", "RGB8", "BayerRG8"}) {
    const auto device = OpenDevice(roi + "&format=" + format);
    device->Start();
    const auto frames = Take(*device, 2);
    ASSERT_EQ(frames.size(), 2u) << format;
    EXPECT_EQ(frames.back().status, FrameStatus::kComplete) << format;
    const Image& image = frames.back().image;
    ASSERT_EQ(image.pixels.size(), cv::Size(kWidth, kHeight)) << format;
    EXPECT_EQ(image.transfer, Transfer::kLinear);
    int wrong = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const int sx = x + kLeft, sy = y + kTop;
        if (std::string(format) == "Mono8")
          wrong += image.pixels.at<std::uint8_t>(y, x) != static_cast<std::uint8_t>(3 * sx + 5 * sy);
        else if (std::string(format) == "RGB8")
          wrong += image.pixels.at<cv::Vec3b>(y, x) !=
                   cv::Vec3b(77, static_cast<std::uint8_t>(sy), static_cast<std::uint8_t>(sx));
        else
          wrong += image.pixels.at<std::uint8_t>(y, x) !=
                   (sy % 2 == 0 ? (sx % 2 == 0 ? 200 : 120) : (sx % 2 == 0 ? 120 : 40));
      }
    EXPECT_EQ(wrong, 0) << format;
    if (std::string(format) == "BayerRG8") {
      EXPECT_EQ(image.mosaic, Mosaic::kRggb);
      const cv::Vec3f color = LinearFloat(image).at<cv::Vec3f>(kHeight / 2, kWidth / 2);
      EXPECT_NEAR(color[0], 40 / 255.0, 1e-3);
      EXPECT_NEAR(color[2], 200 / 255.0, 1e-3);
    }
  }
}

TEST_F(AravisDevice, WritesAllConfigurationOnOpening) {
  StartCamera();
  {
    const auto device = OpenDevice("aravis:127.0.0.1?roi=320x200+16+8&format=Mono8&fps=50&exposure_us=2000");
    device->Start();
    Take(*device, 1);
  }
  // Nothing asked for: the whole sensor and the preferred format, whatever the last program wrote.
  const auto device = OpenDevice("aravis:127.0.0.1?fps=10");
  device->Start();
  const auto frames = Take(*device, 1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].image.pixels.size(), cv::Size(2048, 2048));
  EXPECT_NE(frames[0].image.mosaic, Mosaic::kNone) << "this camera offers Bayer formats";
}

TEST_F(AravisDevice, BadSettingsNameTheRange) {
  StartCamera();
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1?exposure_us=1"), AllOf(HasSubstr("exposure_us"), HasSubstr("10")));
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1?fps=100000"), HasSubstr("fps"));
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1?gain_db=3"), HasSubstr("gain"));
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1?format=BayerRG12p"),
              AllOf(HasSubstr("BayerRG12p"), HasSubstr("Mono8")));
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1?roi=640x480+2000+0"), AllOf(HasSubstr("roi"), HasSubstr("2048")));
}

TEST_F(AravisDevice, OpensBySerialAravisNameOrFirst) {
  StartCamera("T4711");
  const auto devices = ListDevices();
  ASSERT_EQ(devices.size(), 2u) << "the camera, and the simulated one";
  EXPECT_EQ(devices[0].serial, "T4711");
  EXPECT_EQ(devices[0].uri, "aravis:127.0.0.1");
  EXPECT_TRUE(devices[0].available) << devices[0].problem;
  EXPECT_EQ(devices[1].bus, "simulated");
  for (const std::string& uri : {std::string("aravis:T4711"), std::string("aravis:Aravis-T4711"),
                                 std::string("aravis:"), std::string(), devices[0].uri}) {
    const auto device = OpenDevice(uri);
    EXPECT_EQ(device->Info().serial, "T4711") << uri;
  }
  EXPECT_THAT(ErrorOf("aravis:T9"), AllOf(HasSubstr("T9"), HasSubstr("T4711")));
}

TEST_F(AravisDevice, NoCameraIsAnErrorThatSaysWhatToDo) {
  EXPECT_THAT(ErrorOf("aravis:"), AllOf(HasSubstr("GigE Vision"), HasSubstr("sim:studio")));
  EXPECT_THAT(ErrorOf(""), AllOf(HasSubstr("GigE Vision"), HasSubstr("sim:studio")));
  EXPECT_THAT(ErrorOf("aravis:127.0.0.1"), HasSubstr("127.0.0.1"));
  EXPECT_EQ(QueryGigeControl("127.0.0.1", 20ms), GigeControl::kNoAnswer);
}

TEST_F(AravisDevice, ASecondControllerIsRefused) {
  StartCamera();
  EXPECT_EQ(QueryGigeControl("127.0.0.1"), GigeControl::kFree);
  auto first = OpenDevice(kSmall);
  first->Start();
  EXPECT_EQ(QueryGigeControl("127.0.0.1"), GigeControl::kControlled);
  EXPECT_THAT(ErrorOf(kSmall), HasSubstr("another program"));
  const auto devices = ListDevices();
  EXPECT_FALSE(devices.at(0).available);
  EXPECT_THAT(devices.at(0).problem, HasSubstr("another program"));
  Take(*first, 5);  // the first is undisturbed
  EXPECT_EQ(first->State(), DeviceState::kStreaming);
  first.reset();
  EXPECT_EQ(OpenDevice(kSmall)->Info().serial, "T1") << "free again";
}

TEST_F(AravisDevice, FramesWithLossAreMarkedAndCounted) {
  StartCamera("T1", "0.02");
  const auto device =
      OpenDevice("aravis:127.0.0.1?roi=320x240+0+0&fps=50&format=Mono8&packet_size=1400&queue=64");
  device->Start();
  const auto frames = Take(*device, 60);
  std::size_t complete = 0, incomplete = 0, wrong = 0;
  for (const Frame& frame : frames) {
    (frame.status == FrameStatus::kComplete ? complete : incomplete) += 1;
    if (frame.status != FrameStatus::kComplete) continue;
    for (int y = 0; y < frame.image.height(); ++y)
      for (int x = 0; x < frame.image.width(); ++x)
        wrong += frame.image.pixels.at<std::uint8_t>(y, x) != static_cast<std::uint8_t>(3 * x + 5 * y);
  }
  // About 57 packets a frame: at 2 % most frames lose one, and not all.
  EXPECT_GT(incomplete, 10u);
  EXPECT_GT(complete, 0u);
  EXPECT_EQ(wrong, 0u) << "a frame delivered as good has every pixel";
  const DeviceStatistics statistics = device->Statistics();
  EXPECT_EQ(statistics.delivered, complete);
  EXPECT_GE(statistics.incomplete, incomplete);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
}

TEST_F(AravisDevice, ASlowReaderLosesTheOldestAndIsTold) {
  StartCamera();
  const auto device = OpenDevice("aravis:127.0.0.1?roi=64x64+0+0&fps=100&format=Mono8&queue=2");
  device->Start();
  const auto first = Take(*device, 1);
  std::this_thread::sleep_for(1s);
  const std::uint64_t dropped = device->Statistics().dropped;
  EXPECT_GT(dropped, 30u);
  const auto frames = Take(*device, 2);
  EXPECT_GT(frames.front().host_time_s, first.front().host_time_s + 0.5) << "what is left are the newest";
}

TEST_F(AravisDevice, AKilledCameraIsLostAndTeardownReturns) {
  StartCamera();
  auto device = test::OpenDriver(kSmall);
  device->Start();
  Take(*device, 5);
  camera_->Kill();
  const auto start = Clock::now();
  while (device->State() == DeviceState::kStreaming && SecondsSince(start) < 12) device->Next(100ms);
  EXPECT_EQ(device->State(), DeviceState::kLost);
  EXPECT_LT(SecondsSince(start), 8);
  while (device->Next(0ms)) {
  }
  const auto asked = Clock::now();
  EXPECT_FALSE(device->Next(5s));
  EXPECT_LT(SecondsSince(asked), 1) << "a lost device does not let the reader wait";
  EXPECT_FALSE(device->Info().available);
  EXPECT_FALSE(device->Info().problem.empty());
  const auto stopped = Clock::now();
  device->Stop();
  EXPECT_THROW(device->Start(), Error);
  device.reset();
  EXPECT_LT(SecondsSince(stopped), 2) << "what blocks is done behind";

  StartCamera("T2");  // and another is opened while the first is still being let go
  const auto next = test::OpenDriver(kSmall);
  next->Start();
  EXPECT_EQ(Take(*next, 3).size(), 3u);
}

TEST_F(AravisDevice, AShortPauseIsNoLoss) {
  StartCamera();
  const auto device = OpenDevice(kSmall);
  device->Start();
  Take(*device, 3);
  camera_->Signal(SIGSTOP);
  std::this_thread::sleep_for(2s);
  camera_->Signal(SIGCONT);
  Take(*device, 20);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
}

}  // namespace
}  // namespace ulf::aravis_test
