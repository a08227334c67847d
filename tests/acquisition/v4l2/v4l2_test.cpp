// Tests: acquisition/v4l2/v4l2_device, acquisition/v4l2/v4l2_controls, acquisition/v4l2/v4l2_features,
// acquisition/v4l2/v4l2_modes, acquisition/v4l2/v4l2_node, acquisition/device/stream_statistics,
// acquisition/v4l2/v4l2_stream, acquisition/device/live_driver.
//
// Webcams through the kernel's interface, against a camera emulated at the level of its calls: formats,
// controls, both kinds of buffers, and what goes wrong with cameras.
#include <gmock/gmock.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <thread>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/v4l2/v4l2_device.h"
#include "acquisition/v4l2/v4l2_modes.h"
#include "acquisition/v4l2/v4l2_stream.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/v4l2_camera.h"

namespace ulf::v4l2_test {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using test::EmulatedMode;
using test::EmulatedV4l2Camera;
using test::V4l2CameraOptions;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

class V4l2 : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto why = test::NoV4l2Emulation()) GTEST_SKIP() << *why;
  }

  static std::unique_ptr<Device> Open(const std::string& options = "",
                                      const std::string& id = "/dev/video0") {
    return OpenV4l2Device(DeviceUri::Parse("v4l2:" + id + "?settle=0" + options));
  }

  // Patient: the machine may be busy with other things.
  static std::optional<Frame> NextFrame(Device& device, double patience_s = 10) {
    const auto until = Clock::now() + std::chrono::duration<double>(patience_s);
    while (Clock::now() < until) {
      if (auto frame = device.Next(milliseconds(100))) return frame;
      if (device.State() != DeviceState::kStreaming) return std::nullopt;
    }
    return std::nullopt;
  }

  static std::string ErrorOf(const std::function<void()>& work) {
    try {
      work();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  static std::vector<std::string> Notices(Device& device) {
    std::vector<std::string> texts;
    for (const DeviceEvent& event : device.TakeEvents()) texts.push_back(event.text);
    return texts;
  }
};

TEST_F(V4l2, IsListedWithItsSerialOrThePlaceItIsPluggedIn) {
  const EmulatedV4l2Camera with({.node = "video0"});
  auto list = ListV4l2Devices();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].uri, "v4l2:/dev/video0");
  EXPECT_EQ(list[0].maker, "Test Optics");
  EXPECT_EQ(list[0].model, "Test Webcam");
  EXPECT_EQ(list[0].serial, "T1234");
  EXPECT_TRUE(list[0].available) << list[0].problem;
  EXPECT_EQ(Open("", "T1234")->Info().serial, "T1234") << "by serial";
  EXPECT_EQ(Open("", "usb-0000:00:14.0-1")->Info().serial, "T1234") << "by bus path";
  EXPECT_EQ(OpenV4l2Device(DeviceUri::Parse("v4l2:"))->Info().uri, "v4l2:/dev/video0") << "the first";
}

TEST_F(V4l2, WithoutASerialThePlaceIsKnown) {
  const EmulatedV4l2Camera without({.serial = ""});
  const auto list = ListV4l2Devices();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].serial, "");
  EXPECT_EQ(list[0].bus, "usb-0000:00:14.0-1") << "what a calibration is bound to";
}

TEST_F(V4l2, AbsentCamerasAreErrorsThatSayWhatThereIs) {
  const EmulatedV4l2Camera camera;
  EXPECT_THAT(ErrorOf([] { Open("", "/dev/video7"); }),
              AllOf(HasSubstr("/dev/video7"), HasSubstr("ulf devices")));
  EXPECT_THAT(ErrorOf([] { Open("", "S999"); }), AllOf(HasSubstr("S999"), HasSubstr("T1234")));
}

// Every pixel of every frame, in both kinds of buffers.
TEST_F(V4l2, DeliversEveryFormatByteForByte) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(30, 120, 220)), jpeg);
  for (const char* io : {"mmap", "userptr"})
    for (const std::uint32_t padding : {0u, 12u})
      for (const std::uint32_t fourcc :
           {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_GREY,
            V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_SGRBG8, V4L2_PIX_FMT_RGB24}) {
        const std::string name = FourccText(fourcc) + " " + io + " padding " + std::to_string(padding);
        const bool is_jpeg = fourcc == V4L2_PIX_FMT_MJPEG;
        const EmulatedMode mode{.fourcc = fourcc};
        V4l2CameraOptions options{.modes = {mode}, .row_padding = padding};
        if (is_jpeg) options.render = [&](const EmulatedMode&, std::uint32_t) { return jpeg; };
        const EmulatedV4l2Camera camera(options);
        const auto device = Open(std::string("&io=") + io);
        device->Start();
        for (int i = 0; i < 5; ++i) {
          const auto frame = NextFrame(*device);
          ASSERT_TRUE(frame) << name << ": " << device->Info().problem;
          ASSERT_EQ(frame->status, FrameStatus::kComplete) << name;
          const auto bytes =
              is_jpeg ? jpeg : EmulatedV4l2Camera::Ramp(mode, static_cast<std::uint32_t>(frame->id));
          const Image expected =
              ImageFromBytes(*PixelFormatOfFourcc(fourcc), 64, 48, bytes.data(), bytes.size());
          ASSERT_EQ(frame->image.pixels.type(), expected.pixels.type()) << name;
          EXPECT_EQ(cv::norm(frame->image.pixels, expected.pixels, cv::NORM_INF), 0)
              << name << ", frame " << frame->id;
          EXPECT_EQ(frame->image.mosaic, fourcc == V4L2_PIX_FMT_SGRBG8 ? Mosaic::kGrbg : Mosaic::kNone)
              << name;
          if (is_jpeg) {
            ASSERT_TRUE(frame->encoded) << name;
            EXPECT_EQ(*frame->encoded->bytes, std::string(jpeg.begin(), jpeg.end())) << name;
          }
        }
        EXPECT_EQ(camera.Memory(), std::string(io) == "mmap" ? V4L2_MEMORY_MMAP : V4L2_MEMORY_USERPTR);
        device->Stop();
        EXPECT_FALSE(camera.IsStreaming()) << name;
      }
}

TEST_F(V4l2, DriverWithoutUserPointersSaysSo) {
  const EmulatedV4l2Camera camera({.takes_user_pointers = false});
  const auto device = Open("&io=userptr");
  EXPECT_THAT(ErrorOf([&] { device->Start(); }), HasSubstr("io=mmap"));
}

TEST_F(V4l2, StreamsAgainAndInAnotherFormat) {
  const EmulatedV4l2Camera camera(
      {.modes = {{.fourcc = V4L2_PIX_FMT_YUYV, .width = 64, .height = 48},
                 {.fourcc = V4L2_PIX_FMT_GREY, .width = 128, .height = 96, .fps = {50, 100}}}});
  for (const char* options : {"&format=YUYV", "&format=GREY&fps=50", "&format=Mono8", "&size=64x48"}) {
    const auto device = Open(options);
    for (int start = 0; start < 2; ++start) {
      device->Start();
      const auto frame = NextFrame(*device);
      ASSERT_TRUE(frame) << options << " start " << start;
      const bool is_small =
          std::string(options).find("Y") != std::string::npos && std::string(options)[8] == 'Y';
      EXPECT_EQ(frame->image.width(), is_small || std::string(options) == "&size=64x48" ? 64 : 128)
          << options;
      device->Stop();
      EXPECT_EQ(device->State(), DeviceState::kEnded);
    }
  }
}

TEST_F(V4l2, WishesThatCannotBeMetListWhatThereIs) {
  const EmulatedV4l2Camera camera({.modes = {{.fps = {30, 60}}}, .controls = test::UsualControls()});
  EXPECT_THAT(ErrorOf([] { Open("&format=NV12"); }), AllOf(HasSubstr("NV12"), HasSubstr("YUYV")));
  EXPECT_THAT(ErrorOf([] { Open("&format=XYZ"); }), HasSubstr("XYZ"));
  EXPECT_THAT(ErrorOf([] { Open("&size=640x480"); }), AllOf(HasSubstr("640x480"), HasSubstr("64x48")));
  EXPECT_THAT(ErrorOf([] { Open("&fps=25"); }), AllOf(HasSubstr("25"), HasSubstr("30, 60")));
  EXPECT_THAT(ErrorOf([] { Open("&sharpnes=3"); }),
              AllOf(HasSubstr("sharpnes"), HasSubstr("reconnect_s"), HasSubstr("white_balance")));
  EXPECT_THAT(ErrorOf([] { Open("&exposure=1"); }), AllOf(HasSubstr("exposure"), HasSubstr("3 to 2047")));
  EXPECT_THAT(ErrorOf([] { Open("&auto_exposure=often"); }), HasSubstr("Aperture Priority Mode (3)"));
  EXPECT_THROW(Open("&exposure=1"), Refusal);
  EXPECT_THROW(Open("&io=read"), Refusal);
  EXPECT_THAT(ErrorOf([] { Open("&gain=1&gain=2"); }), HasSubstr("gain is given twice"));
  EXPECT_THROW(Open("&size=big"), Refusal);
}

TEST_F(V4l2, ControlsAreFeatures) {
  const EmulatedV4l2Camera camera({.controls = test::UsualControls()});
  const auto features = OpenFeatures("v4l2:T1234");
  const auto list = features->List();
  EXPECT_EQ(list.size(), test::UsualControls().size());
  const auto exposure = features->Find("exposure");
  ASSERT_TRUE(exposure);
  EXPECT_EQ(exposure->name, "exposure_time_absolute");
  EXPECT_EQ(exposure->type, FeatureType::kInteger);
  EXPECT_EQ(exposure->min, 3);
  EXPECT_EQ(exposure->max, 2047);
  EXPECT_EQ(exposure->unit, "100 us");
  EXPECT_FALSE(exposure->writable) << "an automatic moves it";
  EXPECT_THAT(ErrorOf([&] { features->Set("exposure", "50"); }), HasSubstr("switch that off first"));
  EXPECT_EQ(features->Find("auto_exposure")->value, "Aperture Priority Mode");
  features->Set("auto_exposure", "Manual Mode");
  features->Set("exposure", "50");
  EXPECT_EQ(features->Find("exposure_time_absolute")->value, "50");
  EXPECT_TRUE(features->Find("exposure")->writable);
  EXPECT_EQ(features->Find("gain")->unit, "driver units") << "no standard says what a step is";
  features->Set("auto_focus", "false");
  EXPECT_EQ(camera.Control(V4L2_CID_FOCUS_AUTO), 0);
  EXPECT_THAT(ErrorOf([&] { features->Set("exposure", "9999"); }), HasSubstr("3 to 2047"));
  EXPECT_THAT(ErrorOf([&] { features->Set("brightnes", "1"); }),
              AllOf(HasSubstr("brightnes"), HasSubstr("brightness")));
  EXPECT_FALSE(features->Find("no_such"));
}

V4l2Mode Mode(const char* format, int width, int height, std::vector<double> fps) {
  return {*FourccByName(format), *PixelFormatByName(format), width, height, std::move(fps)};
}

// As a usual webcam has them: large pictures are fast only as JPEG.
TEST(V4l2Modes, PreferTheLargestPictureThenFormat) {
  const std::vector<V4l2Mode> modes = {Mode("YUYV", 640, 480, {30}),       Mode("YUYV", 1280, 720, {10}),
                                       Mode("YUYV", 1920, 1080, {5}),      Mode("MJPEG", 640, 480, {30}),
                                       Mode("MJPEG", 1280, 720, {60, 30}), Mode("MJPEG", 1920, 1080, {30}),
                                       Mode("MJPEG", 3840, 2160, {30}),    Mode("YUYV", 800, 600, {30})};
  const auto chosen = [&](V4l2ModeRequest request) {
    const V4l2Mode mode = ChooseV4l2Mode("v4l2:", modes, request);
    return fmt::format("{} {}x{}", mode.format.name, mode.width, mode.height);
  };
  EXPECT_EQ(chosen({}), "MJPEG 1920x1080");
  EXPECT_EQ(chosen({.fps = 60}), "MJPEG 1280x720");
  EXPECT_EQ(chosen({.fourcc = V4L2_PIX_FMT_YUYV}), "YUYV 800x600");
  EXPECT_EQ(chosen({.size = {{640, 480}}}), "YUYV 640x480");
  EXPECT_EQ(chosen({.size = {{1280, 720}}}), "MJPEG 1280x720");
  EXPECT_EQ(chosen({.fourcc = V4L2_PIX_FMT_YUYV, .size = {{1920, 1080}}}), "YUYV 1920x1080");
  EXPECT_EQ(chosen({.size = {{3840, 2160}}}), "MJPEG 3840x2160");
  EXPECT_EQ(chosen({.fps = 5}), "YUYV 1920x1080");
}

// The kernel's colour fields, with its own defaults (linux/videodev2.h).
TEST(V4l2Modes, ColorFieldsMeanMatrixAndRange) {
  v4l2_pix_format pixels{};
  pixels.pixelformat = V4L2_PIX_FMT_YUYV;
  const auto encoding = [&](std::uint32_t colorspace, std::uint32_t ycbcr, std::uint32_t quantization) {
    pixels.colorspace = colorspace;
    pixels.ycbcr_enc = ycbcr;
    pixels.quantization = quantization;
    return YuvEncodingOf(pixels);
  };
  using Encoding = YuvEncoding;
  EXPECT_EQ(encoding(V4L2_COLORSPACE_SRGB, 0, 0), (Encoding{YuvMatrix::kBt601, false}));
  EXPECT_EQ(encoding(V4L2_COLORSPACE_JPEG, 0, 0), (Encoding{YuvMatrix::kBt601, true}));
  EXPECT_EQ(encoding(V4L2_COLORSPACE_SMPTE170M, 0, 0), (Encoding{YuvMatrix::kBt601, false}));
  EXPECT_EQ(encoding(V4L2_COLORSPACE_REC709, 0, 0), (Encoding{YuvMatrix::kBt709, false}));
  EXPECT_EQ(encoding(V4L2_COLORSPACE_BT2020, 0, 0), (Encoding{YuvMatrix::kBt2020, false}));
  EXPECT_EQ(encoding(V4L2_COLORSPACE_SRGB, V4L2_YCBCR_ENC_709, V4L2_QUANTIZATION_FULL_RANGE),
            (Encoding{YuvMatrix::kBt709, true}));
  EXPECT_EQ(encoding(V4L2_COLORSPACE_JPEG, 0, V4L2_QUANTIZATION_LIM_RANGE),
            (Encoding{YuvMatrix::kBt601, false}));
  pixels.colorspace = V4L2_COLORSPACE_SRGB;
  EXPECT_EQ(TransferOf(pixels), Transfer::kSrgb);
  pixels.colorspace = V4L2_COLORSPACE_RAW;
  EXPECT_EQ(TransferOf(pixels), Transfer::kLinear);
  pixels.colorspace = V4L2_COLORSPACE_SRGB;
  pixels.pixelformat = V4L2_PIX_FMT_SRGGB8;
  EXPECT_EQ(TransferOf(pixels), Transfer::kLinear) << "a mosaic is what the sensor saw";
}

TEST_F(V4l2, RangeOfColorsIsTheDrivers) {
  // White in full range, brighter than white in the limited one.
  const auto gray = [](const EmulatedMode& mode, std::uint32_t) {
    std::vector<std::uint8_t> bytes(EmulatedV4l2Camera::RowBytes(mode) * mode.height, 128);
    for (std::size_t i = 0; i < bytes.size(); i += 2) bytes[i] = 235;
    return bytes;
  };
  for (const bool full : {false, true}) {
    const EmulatedV4l2Camera camera(
        {.quantization = full ? V4L2_QUANTIZATION_FULL_RANGE : V4L2_QUANTIZATION_LIM_RANGE, .render = gray});
    const auto device = Open();
    device->Start();
    const auto frame = NextFrame(*device);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->image.pixels.at<cv::Vec3b>(10, 10)[1], full ? 235 : 255);
  }
}

TEST_F(V4l2, AutomaticsAreSwitchedOffAndHeldWhereTheyWere) {
  const EmulatedV4l2Camera camera({.controls = test::UsualControls()});
  const auto device = OpenV4l2Device(DeviceUri::Parse("v4l2:/dev/video0?settle=0.3"));
  EXPECT_EQ(camera.Control(V4L2_CID_EXPOSURE_AUTO), 3) << "they run until then";
  device->Start();
  const auto frame = NextFrame(*device);
  ASSERT_TRUE(frame) << device->Info().problem;
  const int held = camera.Control(V4L2_CID_EXPOSURE_ABSOLUTE);
  EXPECT_GT(held, 100) << "the exposure had time to move";
  EXPECT_EQ(camera.Control(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(camera.Control(V4L2_CID_AUTO_WHITE_BALANCE), 0);
  EXPECT_EQ(device->Held().exposure, true);
  EXPECT_EQ(device->Held().white_balance, true);
  EXPECT_EQ(device->Held().focus, true);
  EXPECT_EQ(camera.Control(V4L2_CID_FOCUS_AUTO), 0);
  EXPECT_EQ(camera.Control(V4L2_CID_WHITE_BALANCE_TEMPERATURE), 4600);
  EXPECT_EQ(camera.Control(V4L2_CID_FOCUS_ABSOLUTE), 250);
  EXPECT_DOUBLE_EQ(frame->exposure_s, 100e-6 * held);
  EXPECT_EQ(frame->gain, 1);
  const auto notices = Notices(*device);
  EXPECT_THAT(notices, Contains(fmt::format("auto_exposure off, exposure_time_absolute held at {}", held)));
  EXPECT_THAT(notices, Contains("white_balance_automatic off, white_balance_temperature held at 4600"));
  EXPECT_THAT(notices, Contains("focus_automatic_continuous off, focus_absolute held at 250"));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(NextFrame(*device));
  EXPECT_EQ(camera.Control(V4L2_CID_EXPOSURE_ABSOLUTE), held) << "and it stays";
  const auto transport = device->Statistics().transport;
  ASSERT_EQ(transport.size(), 1u);
  EXPECT_EQ(transport[0].first, TransportFigure::kWhileSettling);
  EXPECT_GT(transport[0].second, 2) << "not handed out, but counted";
  // Opened again by its name it goes on as it was, whatever was done to it.
  const std::string uri = device->Info().uri;
  device->Stop();
  auto features = OpenFeatures("v4l2:/dev/video0");
  features->Set("exposure", "900");
  features->Set("auto_exposure", "Aperture Priority Mode");
  const auto again = OpenV4l2Device(DeviceUri::Parse(uri));
  again->Start();
  const auto next = NextFrame(*again);
  ASSERT_TRUE(next) << uri;
  EXPECT_DOUBLE_EQ(next->exposure_s, frame->exposure_s) << uri;
}

TEST_F(V4l2, AnAutomaticThatCannotBeSwitchedOffIsSaid) {
  auto controls = test::UsualControls();
  for (auto& control : controls)
    if (control.id == V4L2_CID_EXPOSURE_AUTO) control.refuses = EIO;
  const EmulatedV4l2Camera camera({.controls = controls});
  const auto device = Open();
  device->Start();
  const auto frame = NextFrame(*device);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->exposure_s, 0) << "the camera chooses it: unknown";
  EXPECT_EQ(device->Held().exposure, false);
  EXPECT_EQ(device->Held().white_balance, true);
  EXPECT_THAT(Notices(*device),
              Contains(AllOf(HasSubstr("auto_exposure stays on"), HasSubstr("between views"))));
}

TEST_F(V4l2, ControlsAreSetByNameAndReadBack) {
  const EmulatedV4l2Camera camera({.controls = test::UsualControls()});
  const auto device = Open("&exposure=250&gain=40&white_balance=5000&focus_absolute=11&brightness=-5");
  device->Start();
  const auto frame = NextFrame(*device);
  ASSERT_TRUE(frame) << device->Info().problem;
  EXPECT_EQ(camera.Control(V4L2_CID_EXPOSURE_ABSOLUTE), 250);
  EXPECT_EQ(camera.Control(V4L2_CID_GAIN), 40);
  EXPECT_EQ(camera.Control(V4L2_CID_WHITE_BALANCE_TEMPERATURE), 5000);
  EXPECT_EQ(camera.Control(V4L2_CID_FOCUS_ABSOLUTE), 11);
  EXPECT_EQ(camera.Control(V4L2_CID_BRIGHTNESS), -5);
  EXPECT_DOUBLE_EQ(frame->exposure_s, 0.025);
}

TEST_F(V4l2, AnAutomaticThatIsAskedForStaysOn) {
  const EmulatedV4l2Camera camera({.controls = test::UsualControls()});
  const auto device = Open("&auto_exposure=Aperture_Priority_Mode&auto_focus=on");
  device->Start();
  const auto frame = NextFrame(*device);
  ASSERT_TRUE(frame);
  EXPECT_EQ(camera.Control(V4L2_CID_EXPOSURE_AUTO), 3);
  EXPECT_EQ(camera.Control(V4L2_CID_FOCUS_AUTO), 1);
  EXPECT_EQ(device->Held().exposure, false);
  EXPECT_EQ(device->Held().white_balance, true);
  EXPECT_EQ(device->Held().focus, false);
  EXPECT_EQ(camera.Control(V4L2_CID_AUTO_WHITE_BALANCE), 0);
  EXPECT_EQ(frame->exposure_s, 0);
}

TEST_F(V4l2, MissingControlsAreNotToldAsHeld) {
  const EmulatedV4l2Camera camera;
  const auto device = Open();
  device->Start();
  ASSERT_TRUE(NextFrame(*device));
  EXPECT_FALSE(device->Held().exposure);
  EXPECT_FALSE(device->Held().white_balance);
  EXPECT_FALSE(device->Held().focus);
}

TEST_F(V4l2, TimesAreTheKernelsMonotonicClock) {
  const auto now_s = [] { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); };
  for (const bool at_start : {true, false}) {
    const EmulatedV4l2Camera camera(
        {.controls = test::UsualControls(),
         .timestamp_flags = static_cast<std::uint32_t>(V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) |
                            (at_start ? V4L2_BUF_FLAG_TSTAMP_SRC_SOE : V4L2_BUF_FLAG_TSTAMP_SRC_EOF)});
    const auto device = Open("&exposure=2000");  // 0.2 s: half of it is well seen
    const double before_s = now_s();
    device->Start();
    double last_s = 0;
    for (int i = 0; i < 5; ++i) {
      const auto frame = NextFrame(*device);
      ASSERT_TRUE(frame);
      EXPECT_GT(frame->device_time_s, last_s);
      last_s = frame->device_time_s;
      const double stamp_s = frame->device_time_s - (at_start ? 0.1 : -0.1);
      EXPECT_GE(stamp_s, before_s) << (at_start ? "start" : "end");
      EXPECT_LE(stamp_s, now_s()) << (at_start ? "start" : "end");
    }
    const auto statistics = device->Statistics();
    ASSERT_TRUE(statistics.clock_offset_s);
    const double wall_s =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    EXPECT_NEAR(*statistics.clock_offset_s, wall_s - now_s(), 0.5);
  }
}

TEST_F(V4l2, DamagedFramesAreIncomplete) {
  EmulatedV4l2Camera camera;
  const auto device = Open();
  device->Start();
  ASSERT_TRUE(NextFrame(*device));
  camera.DamageFrames(3);
  int incomplete = 0;
  for (int i = 0; i < 60 && incomplete < 3; ++i) {
    const auto frame = NextFrame(*device);
    ASSERT_TRUE(frame);
    incomplete += frame->status == FrameStatus::kIncomplete;
  }
  EXPECT_EQ(incomplete, 3);
  EXPECT_EQ(device->Statistics().incomplete, 3u);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
}

TEST_F(V4l2, CutJpegIsIncompleteOneWithoutTablesIsWhole) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(30, 120, 220)), jpeg);
  std::vector<std::uint8_t> without;
  for (std::size_t at = 2; at < jpeg.size();) {
    if (at == 2) without.assign(jpeg.begin(), jpeg.begin() + 2);
    if (jpeg[at + 1] == 0xDA) {
      without.insert(without.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
      break;
    }
    const std::size_t end = at + 2 + static_cast<std::size_t>(jpeg[at + 2] << 8 | jpeg[at + 3]);
    if (jpeg[at + 1] != 0xC4)
      without.insert(without.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                     jpeg.begin() + static_cast<std::ptrdiff_t>(end));
    at = end;
  }
  ASSERT_LT(without.size(), jpeg.size());
  without.insert(without.end(), 100, 0);  // padding behind the end
  const std::vector<std::uint8_t> cut(jpeg.begin(), jpeg.end() - 40);
  const EmulatedV4l2Camera camera(
      {.modes = {{.fourcc = V4L2_PIX_FMT_MJPEG}},
       .render = [&](const EmulatedMode&, std::uint32_t sequence) { return sequence % 2 ? cut : without; }});
  const auto device = Open();
  device->Start();
  std::set<bool> seen;
  for (int i = 0; i < 40 && seen.size() < 2; ++i) {
    const auto frame = NextFrame(*device);
    ASSERT_TRUE(frame);
    const bool is_cut = frame->id % 2;
    seen.insert(is_cut);
    EXPECT_EQ(frame->status, is_cut ? FrameStatus::kIncomplete : FrameStatus::kComplete) << frame->id;
    if (is_cut) continue;
    ASSERT_TRUE(frame->encoded);
    EXPECT_EQ(frame->encoded->bytes->size(), jpeg.size()) << "tables in, padding off";
    EXPECT_THAT(*frame->encoded->bytes, HasSubstr("\xFF\xC4"));
  }
  EXPECT_EQ(seen.size(), 2u);
  EXPECT_FALSE(StandaloneJpeg(cut));
}

TEST_F(V4l2, GapsInTheSequenceAreCounted) {
  EmulatedV4l2Camera camera;
  const auto device = Open("&queue=100");
  device->Start();
  ASSERT_TRUE(NextFrame(*device));
  const std::uint64_t before = device->Statistics().missing;
  camera.SkipFrames(7);
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(NextFrame(*device));
  // A busy machine loses frames on top; all are counted.
  EXPECT_GE(device->Statistics().missing, before + 7);
}

TEST_F(V4l2, ASlowReaderLosesTheOldestAndTheyAreCounted) {
  const EmulatedV4l2Camera camera;
  const auto device = Open("&queue=2");
  device->Start();
  const auto first = NextFrame(*device);
  ASSERT_TRUE(first);
  const auto until = Clock::now() + std::chrono::seconds(10);
  while (device->Statistics().dropped < 5 && Clock::now() < until)
    std::this_thread::sleep_for(milliseconds(10));
  EXPECT_GE(device->Statistics().dropped, 5u);
  const auto next = NextFrame(*device);
  ASSERT_TRUE(next);
  EXPECT_GT(next->id, first->id + 5) << "what is old went";
}

TEST_F(V4l2, UnpluggedIsLostAtOnceAndPluggedInIsThereAgain) {
  EmulatedV4l2Camera camera;
  for (const char* io : {"&io=mmap", "&io=userptr"}) {
    const auto device = Open(io);
    device->Start();
    ASSERT_TRUE(NextFrame(*device)) << io;
    camera.Unplug();
    const auto unplugged = Clock::now();
    while (device->State() == DeviceState::kStreaming && Clock::now() < unplugged + std::chrono::seconds(5))
      device->Next(milliseconds(20));
    EXPECT_EQ(device->State(), DeviceState::kLost) << io;
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - unplugged).count(), 2) << "not by patience";
    EXPECT_THAT(device->Info().problem, AllOf(HasSubstr("unplugged"), HasSubstr("/dev/video0")));
    EXPECT_FALSE(device->Info().available);
    EXPECT_EQ(ListV4l2Devices().size(), 0u);
    EXPECT_THAT(ErrorOf([] { Open(); }), HasSubstr("there is no /dev/video0"));
    device->Stop();
    EXPECT_THAT(ErrorOf([&] { device->Start(); }), HasSubstr("open the device again"));
    camera.PlugIn();
    const auto again = Open(io);
    again->Start();
    EXPECT_TRUE(NextFrame(*again)) << io;
  }
}

TEST_F(V4l2, ACameraInUseSaysWhatToDo) {
  EmulatedV4l2Camera camera;
  camera.SetBusy(true);
  const std::string at_opening = ErrorOf([] { Open(); });
  EXPECT_THAT(at_opening, AllOf(HasSubstr("another program streams from /dev/video0"), HasSubstr("fuser")));
  camera.SetBusy(false);
  const auto device = Open();
  camera.SetBusy(true);
  EXPECT_THAT(ErrorOf([&] { device->Start(); }), HasSubstr("another program streams"));
}

TEST(V4l2Node, MissingPermissionNamesGroupAndRule) {
  const std::string text = V4l2Problem("/dev/null", EACCES);
  EXPECT_THAT(text, AllOf(HasSubstr("/dev/null"), HasSubstr("group root"), HasSubstr("usermod"),
                          HasSubstr("70-ulf-cameras.rules")));
  EXPECT_THAT(V4l2Problem("/dev/video9", EACCES), HasSubstr("group video"));
}

TEST(V4l2Node, BusyNamesTheProgramThatHasItOpen) {
  const test::ScratchFolder scratch;
  const std::string node = (scratch / "video").string();
  test::ChildProcess other({"/bin/sh", "-c", "exec 3>" + node + "; echo open; exec sleep 60"});
  ASSERT_THAT(other.ReadUntil("open", 10), HasSubstr("open"));
  const std::string text = V4l2Problem(node, EBUSY);
  EXPECT_THAT(text, HasSubstr("another program streams from " + node));
  EXPECT_THAT(text, HasSubstr(fmt::format("(process {})", other.Pid())));
}

TEST_F(V4l2, ProgramListsFormatsSizesAndRates) {
  const EmulatedV4l2Camera camera({.modes = {{V4L2_PIX_FMT_YUYV, 640, 480, {30, 15}},
                                             {V4L2_PIX_FMT_YUYV, 1280, 720, {10}},
                                             {V4L2_PIX_FMT_GREY, 640, 480, {60}},
                                             {V4L2_PIX_FMT_H264, 1920, 1080, {30}}},
                                   .controls = test::UsualControls()});
  const auto shown = test::RunUlf("features v4l2:/dev/video0");
  ASSERT_EQ(shown.exit_code, 0) << shown.errors;
  EXPECT_THAT(shown.output,
              AllOf(HasSubstr("YUYV"), HasSubstr("640x480 at 30, 15"), HasSubstr("1280x720 at 10"),
                    HasSubstr("Mono8 (GREY)"), HasSubstr("640x480 at 60"), HasSubstr("H264"),
                    HasSubstr("not read by ulf")));
  const auto json = JsonFromText(test::RunUlf("features v4l2:/dev/video0 --json").output);
  ASSERT_EQ(json["formats"].size(), 4u);
  EXPECT_EQ(json["formats"][1]["fourcc"], "YUYV");
  EXPECT_EQ(json["formats"][1]["width"], 1280);
  EXPECT_EQ(json["formats"][1]["fps"], std::vector<double>{10});
  EXPECT_EQ(json["formats"][3]["supported"], false);
}

// The program itself, which knows nothing of emulation.
TEST_F(V4l2, ProgramShowsAndSetsControls) {
  const EmulatedV4l2Camera camera({.controls = test::UsualControls()});
  const auto shown = test::RunUlf("features v4l2:/dev/video0 --json");
  EXPECT_EQ(shown.exit_code, 0) << shown.errors;
  EXPECT_THAT(shown.output, AllOf(HasSubstr("exposure_time_absolute"), HasSubstr("2047")));
  const auto set = test::RunUlf("features v4l2:/dev/video0 'auto_exposure=Manual Mode' exposure=77");
  EXPECT_EQ(set.exit_code, 0) << set.errors;
  EXPECT_EQ(camera.Control(V4L2_CID_EXPOSURE_ABSOLUTE), 77);
  const auto refused = test::RunUlf("features v4l2:/dev/video0 exposure=1");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("2047"));
}

TEST_F(V4l2, ASilentCameraIsSaidAndThenGivenUp) {
  EmulatedV4l2Camera camera;
  const auto device = Open();
  device->Start();
  ASSERT_TRUE(NextFrame(*device));
  camera.HoldBack(true);
  bool stalled = false;
  const auto begun = Clock::now();
  while (device->State() == DeviceState::kStreaming && Clock::now() < begun + std::chrono::seconds(20)) {
    device->Next(milliseconds(50));
    for (const DeviceEvent& event : device->TakeEvents()) stalled |= event.kind == DeviceEventKind::kStalled;
  }
  EXPECT_TRUE(stalled);
  EXPECT_EQ(device->State(), DeviceState::kLost);
  EXPECT_THAT(device->Info().problem, HasSubstr("no frame for"));
}

TEST_F(V4l2, StopsAtOnceWhileNothingComes) {
  EmulatedV4l2Camera camera;
  camera.HoldBack(true);
  const auto device = Open();
  device->Start();
  const auto begun = Clock::now();
  device->Stop();
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - begun).count(), 1);
  EXPECT_FALSE(camera.IsStreaming());
}

}  // namespace
}  // namespace ulf::v4l2_test
