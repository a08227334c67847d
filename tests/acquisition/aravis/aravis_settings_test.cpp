// Tests: acquisition/aravis/aravis_configuration, acquisition/aravis/aravis_options,
// acquisition/aravis/aravis_region, acquisition/aravis/aravis_calls, acquisition/aravis/aravis_stream.
//
// What an aravis: URI asks for reaches the camera, stands in frames and statistics, and what a camera cannot
// do is an error that says so. The camera is full_camera.xml's where Aravis's own fake has no such setting.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <map>
#include <thread>

#include "acquisition/device/features.h"
#include "acquisition/opening/open_device.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/acquisition/aravis/aravis_fixture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::aravis_settings_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class AravisSettings : public CameraInNamespace {};

std::string ErrorOf(const std::string& options) {
  try {
    OpenDriver("aravis:127.0.0.1?" + options);
  } catch (const Refusal& error) {
    return error.what();
  }
  ADD_FAILURE() << options << ": no usage error";
  return "";
}

std::string ValueOf(FeatureAccess& access, const std::string& name) {
  const auto feature = access.Find(name);
  return feature ? feature->value : "no " + name;
}

std::map<TransportFigure, double> Transport(const Device& device) {
  const auto list = device.Statistics().transport;
  return {list.begin(), list.end()};
}

std::vector<std::string> Said(Device& device, DeviceEventKind kind) {
  std::vector<std::string> texts;
  for (const DeviceEvent& event : device.TakeEvents())
    if (event.kind == kind) texts.push_back(event.text);
  return texts;
}

TEST_F(AravisSettings, ReachCameraFramesAndStatistics) {
  StartFullCamera();
  {
    const auto device = OpenDriver(
        "aravis:127.0.0.1?user_set=UserSet1&exposure_us=4000&gain_db=12&black_level=8&white_balance=1.5,2.25"
        "&fps=40&format=Mono8&roi=320x240+16+8&packet_size=1400&resend=off&packet_timeout_ms=30"
        "&frame_retention_ms=150&socket_buffer=100000&buffers=7&queue=64");
    device->Start();
    int complete = 0;
    for (const Frame& frame : Take(*device, 10)) {
      EXPECT_DOUBLE_EQ(frame.exposure_s, 0.004);
      EXPECT_NEAR(frame.gain, std::pow(10, 12 / 20.0), 1e-9);
      EXPECT_NEAR(frame.black_level, 8 / 255.0, 1e-9);
      if (frame.status != FrameStatus::kComplete)
        continue;  // nothing is asked for again: a busy machine loses
      ++complete;
      EXPECT_EQ(frame.image.pixels.at<std::uint8_t>(5, 7),
                static_cast<std::uint8_t>(3 * (16 + 7) + 5 * (8 + 5)));
    }
    EXPECT_GT(complete, 0);
    std::this_thread::sleep_for(250ms);  // the counters are taken ten times a second
    const auto transport = Transport(*device);
    EXPECT_EQ(transport.at(TransportFigure::kPacketSize), 1400);
    EXPECT_EQ(transport.at(TransportFigure::kResends), 0);
    EXPECT_EQ(transport.at(TransportFigure::kPacketTimeoutMs), 30);
    EXPECT_EQ(transport.at(TransportFigure::kFrameRetentionMs), 150);
    EXPECT_EQ(transport.at(TransportFigure::kSocketBuffer), 100000);
    EXPECT_EQ(transport.at(TransportFigure::kBuffers), 7);
    EXPECT_GE(transport.at(TransportFigure::kFramesCompleted), complete);
    EXPECT_EQ(transport.at(TransportFigure::kWrongPacketIds), 0);
    EXPECT_GT(transport.at(TransportFigure::kPacketsReceived), 10 * 320 * 240 / 1400);
    EXPECT_EQ(transport.at(TransportFigure::kResendRequests), 0);
    // With so small a buffer and no resending a busy computer may lose packets.
    EXPECT_THAT(Said(*device, DeviceEventKind::kNotice), ::testing::Each(HasSubstr("arrived incomplete")))
        << "the camera took all as it was told";
  }
  // The camera keeps what was written.
  const auto access = OpenFeatures("aravis:127.0.0.1");
  EXPECT_EQ(ValueOf(*access, "UserSetLoaded"), "1");
  EXPECT_EQ(ValueOf(*access, "ExposureAuto"), "Off");
  EXPECT_EQ(ValueOf(*access, "AcquisitionFrameRate"), "40");
  EXPECT_EQ(ValueOf(*access, "BlackLevel"), "8");
  EXPECT_EQ(ValueOf(*access, "BalanceWhiteAuto"), "Off");
  for (const auto& [colour, ratio] : {std::pair("Red", "1.5"), std::pair("Blue", "2.25")}) {
    access->Set("BalanceRatioSelector", colour);
    EXPECT_EQ(ValueOf(*access, "BalanceRatio"), ratio) << colour;
  }
}

TEST_F(AravisSettings, StatisticsTellThroughputAndClock) {
  StartCamera();
  const auto device = OpenDriver("aravis:127.0.0.1?roi=320x240+0+0&fps=50&format=Mono8&queue=64");
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  device->Start();
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
  ASSERT_EQ(Take(*device, 40).size(), 40u);
  const DeviceStatistics statistics = device->Statistics();
  EXPECT_EQ(statistics.bytes, 40u * 320 * 240);
  EXPECT_GT(statistics.seconds, 0.7);
  EXPECT_EQ(statistics.out_of_order, 0u);
  ASSERT_TRUE(statistics.clock_offset_s && statistics.clock_jitter_s);
  // The fake camera's clock is this computer's, taken when it begins to draw the picture.
  EXPECT_GT(*statistics.clock_offset_s, 0);
  EXPECT_LT(*statistics.clock_offset_s, 0.5);
  EXPECT_LT(*statistics.clock_jitter_s, 0.5);
  EXPECT_EQ(statistics.transport.front().first, TransportFigure::kPixelRate);
  EXPECT_NEAR(statistics.transport.front().second, 1e-6 * 40 * 320 * 240 / statistics.seconds, 0.2);
  device->Stop();
  EXPECT_EQ(device->State(), DeviceState::kConnected);
  const double stopped_at_s = device->Statistics().seconds;
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(device->Statistics().seconds, stopped_at_s) << "time stands still without a stream";
}

TEST_F(AravisSettings, WindowIsInUnbinnedSensorPixels) {
  StartFullCamera();
  EXPECT_EQ(OpenDriver("aravis:127.0.0.1?roi=320x240+16+8")->Window(),
            (SensorWindow{
                .sensor_width = 2048, .sensor_height = 2048, .x = 16, .y = 8, .width = 320, .height = 240}));
  EXPECT_EQ(OpenDriver("aravis:127.0.0.1?binning=2x4")->Window(), (SensorWindow{.sensor_width = 2048,
                                                                                .sensor_height = 2048,
                                                                                .x = 0,
                                                                                .y = 0,
                                                                                .width = 2048,
                                                                                .height = 2048,
                                                                                .binning_x = 2,
                                                                                .binning_y = 4}));
  EXPECT_EQ(OpenDriver("aravis:127.0.0.1?binning=2x2&roi=512x256+64+32")->Window(),
            (SensorWindow{.sensor_width = 2048,
                          .sensor_height = 2048,
                          .x = 128,
                          .y = 64,
                          .width = 1024,
                          .height = 512,
                          .binning_x = 2,
                          .binning_y = 2}));
  EXPECT_EQ(OpenDriver("aravis:127.0.0.1")->Window()->binning_x, 1) << "what the last program set is undone";
}

TEST_F(AravisSettings, OutOfRangeIsAnErrorWithTheRange) {
  StartFullCamera();
  EXPECT_THAT(ErrorOf("exposure_us=2e6"), AllOf(HasSubstr("exposure_us"), HasSubstr("10 to 1000000")));
  EXPECT_THAT(ErrorOf("gain_db=30"), AllOf(HasSubstr("gain_db"), HasSubstr("0 to 24")));
  EXPECT_THAT(ErrorOf("black_level=100"), AllOf(HasSubstr("black_level"), HasSubstr("0 to 64")));
  EXPECT_THAT(ErrorOf("white_balance=1,9"), AllOf(HasSubstr("white_balance"), HasSubstr("0 to 8")));
  EXPECT_THAT(ErrorOf("exposure_us=100000&fps=20"), AllOf(HasSubstr("fps"), HasSubstr("to 10")))
      << "the exposure limits the rate";
  EXPECT_THAT(ErrorOf("binning=8x1"), AllOf(HasSubstr("binning"), HasSubstr("1 to 4")));
  EXPECT_THAT(ErrorOf("roi=4096x16+0+0"), HasSubstr("roi"));
  EXPECT_THAT(ErrorOf("trigger=Line7"), AllOf(HasSubstr("Line7"), HasSubstr("Line0, Software")));
  EXPECT_THAT(ErrorOf("user_set=Mine"), AllOf(HasSubstr("Mine"), HasSubstr("Default, UserSet1")));
}

TEST_F(AravisSettings, UnsupportedSettingIsANamedError) {
  StartCamera();
  EXPECT_THAT(ErrorOf("gain_db=3"), HasSubstr("gain_raw"));
  EXPECT_THAT(ErrorOf("gain_raw=400"), AllOf(HasSubstr("gain_raw"), HasSubstr("0 to 10")));
  EXPECT_THAT(ErrorOf("black_level=3"), HasSubstr("black_level"));
  EXPECT_THAT(ErrorOf("white_balance=1,2"), HasSubstr("white_balance"));
  EXPECT_THAT(ErrorOf("white_balance=auto"), HasSubstr("white_balance"));
  EXPECT_THAT(ErrorOf("user_set=Default"), HasSubstr("user_set"));
  EXPECT_THAT(ErrorOf("chunks=on"), HasSubstr("chunks"));
  const auto device = OpenDriver("aravis:127.0.0.1?gain_raw=7");
  EXPECT_EQ(ValueOf(*OpenFeatures("aravis:127.0.0.1"), "GainRaw"), "7") << "readable while another controls";
}

TEST_F(AravisSettings, InvalidValuesAreWrongUsage) {
  for (const char* options :
       {"binning=2", "white_balance=warm", "resend=yes", "priority=top", "packet_delay_ns=-1", "buffers=1",
        "gain_db=1&gain_raw=1", "chunks=1", "auto_gain=yes", "auto_exposure=on&exposure_us=5", "settle=-1"})
    EXPECT_THROW(OpenDriver("aravis:127.0.0.1?" + std::string(options)), Refusal) << options;
}

TEST_F(AravisSettings, SoftwareTriggerGivesAFrameACall) {
  StartCamera();
  const auto device = OpenDriver("aravis:127.0.0.1?trigger=software&roi=64x64+0+0&format=Mono8");
  device->Start();
  std::uint64_t last_id = 0;
  for (int i = 0; i < 5; ++i) {
    std::this_thread::sleep_for(150ms);  // nothing comes meanwhile
    const double asked_s =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    const auto frame = device->Next(5s);
    ASSERT_TRUE(frame) << i;
    EXPECT_GE(frame->device_time_s, asked_s) << "taken after the call";
    if (i > 0) {
      EXPECT_EQ(frame->id, last_id + 1);
    }
    last_id = frame->id;
  }
  EXPECT_EQ(device->Statistics().delivered, 5u);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
}

TEST_F(AravisSettings, WaitingForAHardwareTriggerIsNoLoss) {
  StartCamera();
  const auto device = OpenDriver("aravis:127.0.0.1?trigger=Line0&roi=64x64+0+0&fps=50");
  device->Start();
  const auto start = Clock::now();
  EXPECT_FALSE(device->Next(4500ms));
  EXPECT_GT(SecondsSince(start), 4.4);
  EXPECT_EQ(device->State(), DeviceState::kStreaming);
  EXPECT_TRUE(device->TakeEvents().empty());
  camera_->Kill();  // and a camera that goes meanwhile is missed all the same
  StartCamera("T2");
  const auto restarted = Clock::now();
  while (device->State() == DeviceState::kStreaming && SecondsSince(restarted) < 6) device->Next(50ms);
  EXPECT_EQ(device->State(), DeviceState::kLost);
}

TEST_F(AravisSettings, ReportsRefusedSettingsOnce) {
  StartFullCamera();
  const auto device = OpenDriver("aravis:127.0.0.1?chunks=on&roi=64x64+0+0&format=Mono8&priority=realtime");
  device->Start();
  Take(*device, 20);
  std::this_thread::sleep_for(200ms);
  const auto notices = Said(*device, DeviceEventKind::kNotice);
  EXPECT_THAT(notices, Contains(HasSubstr("frames contain none"))) << "this camera promises chunk data";
  const double granted = Transport(*device).at(TransportFigure::kRealTimePriority);
  const auto told = std::count_if(notices.begin(), notices.end(), [](const std::string& text) {
    return text.find("priority") != std::string::npos;
  });
  EXPECT_EQ(told, granted != 0 ? 0 : 1);
}

// The region is checked against the camera's limits and steps before its size is written.
TEST_F(AravisSettings, RegionOffTheStepsNamesTheNearest) {
  StartFullCamera();
  EXPECT_THAT(ErrorOf("format=Mono8&roi=321x241+0+0"),
              AllOf(HasSubstr("nearest is roi=320x242+0+0"), HasSubstr("in steps of 4")));
  EXPECT_THAT(ErrorOf("format=Mono8&roi=320x240+18+9"), HasSubstr("nearest is roi=320x240+20+10"));
  EXPECT_THAT(ErrorOf("format=Mono8&roi=320x240+2000+0"), HasSubstr("nearest is roi=320x240+1728+0"));
  EXPECT_THAT(ErrorOf("format=Mono8&roi=8x8+0+0"), HasSubstr("nearest is roi=16x16+0+0"));
  EXPECT_THAT(ErrorOf("format=Mono8&binning=2x2&roi=1028x1024+0+0"),
              HasSubstr("nearest is roi=1024x1024+0+0"));
  EXPECT_EQ(OpenDriver("aravis:127.0.0.1?format=Mono8&roi=320x242+20+10")->Window()->x, 20);
}

// An odd offset would exchange a mosaic's colours: refused, also where the camera itself would take it.
TEST_F(AravisSettings, AMosaicKeepsItsColoursInEveryRegion) {
  StartCamera();
  EXPECT_EQ(OpenDriver("aravis:127.0.0.1?format=Mono8&roi=64x64+17+9")->Window()->x, 17);
  EXPECT_THAT(ErrorOf("format=BayerRG8&roi=64x64+17+9"),
              AllOf(HasSubstr("nearest is roi=64x64+18+10"), HasSubstr("mosaic")));
  for (const char* region : {"64x64+0+0", "64x64+18+10", "65x63+2+0"}) {
    const auto device = OpenDriver("aravis:127.0.0.1?format=BayerRG8&fps=30&roi=" + std::string(region));
    device->Start();
    const auto frames = Take(*device, 2);
    ASSERT_EQ(frames.size(), 2u);
    // The camera's red sites send 200, its green ones 120, its blue ones 40.
    const auto middle = Demosaiced(frames.back().image).pixels.at<cv::Vec3w>(30, 30);
    EXPECT_EQ(middle, cv::Vec3w(40 * 257, 120 * 257, 200 * 257)) << region;
  }
}

TEST_F(AravisSettings, SensorSizeFallsBackToLargestImage) {
  const ScratchFolder scratch;
  std::string description = ReadWholeFile(FULL_CAMERA);
  for (const std::string name : {"SensorWidth", "SensorHeight"})
    for (std::size_t at = 0; (at = description.find(name, at)) != std::string::npos;)
      description.replace(at, name.size(), "Unnamed" + name.substr(6));
  WriteFileAtomically(scratch / "camera.xml", description);
  StartCamera("W1", "0", "127.0.0.1", (scratch / "camera.xml").string());
  const SensorWindow window = *OpenDriver("aravis:127.0.0.1?binning=2x2&roi=512x256+64+32")->Window();
  EXPECT_EQ(window, (SensorWindow{2048, 2048, 128, 64, 1024, 512, 2, 2}));
}

TEST_F(AravisSettings, ReportsValuesTheCameraChanged) {
  StartFullCamera();
  // It keeps gain in tenths of a decibel, black level in quarters, ratios in thousandths.
  const auto device =
      OpenDriver("aravis:127.0.0.1?gain_db=0.17&black_level=1.1&white_balance=0.0125,2.25&exposure_us=4000");
  EXPECT_THAT(Said(*device, DeviceEventKind::kNotice),
              ::testing::UnorderedElementsAre(HasSubstr("changed gain_db=0.17 to 0.1"),
                                              HasSubstr("changed black_level=1.1 to 1"),
                                              HasSubstr("changed white_balance (red)=0.0125 to 0.012")));
}

// An address as in a network: at those of this computer nothing is negotiated.
constexpr const char* kFarAddress = "10.77.0.1";
bool HaveFarAddress() {
  ifreq request{};
  std::strcpy(request.ifr_name, "lo:1");
  auto* address = reinterpret_cast<sockaddr_in*>(&request.ifr_addr);
  address->sin_family = AF_INET;
  inet_pton(AF_INET, kFarAddress, &address->sin_addr);
  const int socket_fd = socket(AF_INET, SOCK_DGRAM, 0);
  const bool have = ioctl(socket_fd, SIOCSIFADDR, &request) == 0;
  close(socket_fd);
  return have;
}

TEST_F(AravisSettings, PacketSizeIsNegotiatedOrReported) {
  ASSERT_TRUE(HaveFarAddress());
  const std::string uri = fmt::format("aravis:{}?roi=64x64+0+0&fps=50&format=Mono8", kFarAddress);
  const auto streaming = [](const std::string& asked) {
    auto device = OpenDriver(asked);
    device->Start();
    EXPECT_EQ(Take(*device, 3).size(), 3u);
    device->Stop();
    return device;
  };
  const auto silent = HasSubstr("sent no test packet that arrived");
  // Its test packets of up to 4000 bytes arrive; on a busy computer those may be late, too.
  StartCamera("N1", "0", kFarAddress, FULL_CAMERA);
  std::unique_ptr<Device> device;
  for (int attempt = 0;
       attempt < 5 && (!device || Transport(*device).at(TransportFigure::kPacketSizeNegotiated) == 0);
       ++attempt) {
    device.reset();
    device = streaming(uri);
  }
  EXPECT_EQ(Transport(*device).at(TransportFigure::kPacketSizeNegotiated), 1);
  EXPECT_GT(Transport(*device).at(TransportFigure::kPacketSize), 576);
  EXPECT_LE(Transport(*device).at(TransportFigure::kPacketSize), 4000);
  EXPECT_THAT(Said(*device, DeviceEventKind::kNotice), Not(Contains(silent)));
  device.reset();
  camera_->Kill();

  StartCamera("N2", "0", kFarAddress);
  device = streaming(uri);
  EXPECT_EQ(Transport(*device).at(TransportFigure::kPacketSizeNegotiated), 0);
  EXPECT_EQ(Transport(*device).at(TransportFigure::kPacketSize), 1400) << "its own";
  EXPECT_THAT(Said(*device, DeviceEventKind::kNotice), Contains(AllOf(silent, HasSubstr("1400 bytes"))));
  device.reset();
  device = streaming(uri + "&packet_size=1000");
  EXPECT_EQ(Transport(*device).at(TransportFigure::kPacketSizeNegotiated), 0);
  EXPECT_EQ(Transport(*device).at(TransportFigure::kPacketSize), 1000);
  EXPECT_THAT(Said(*device, DeviceEventKind::kNotice), Not(Contains(silent)));
}

// What the kernel gave is read from the socket, not computed.
TEST_F(AravisSettings, ReportsACutReceiveBuffer) {
  StartCamera();
  const auto device =
      OpenDriver("aravis:127.0.0.1?socket_buffer=900000000&roi=320x240+0+0&fps=50&format=Mono8");
  device->Start();
  Take(*device, 10);
  std::this_thread::sleep_for(250ms);
  const auto transport = Transport(*device);
  EXPECT_EQ(transport.at(TransportFigure::kSocketBufferAsked), 900000000);
  ASSERT_TRUE(transport.count(TransportFigure::kSocketBuffer));
  EXPECT_LT(transport.at(TransportFigure::kSocketBuffer), 900000000);
  EXPECT_GT(transport.at(TransportFigure::kSocketBuffer), 50000);
  EXPECT_THAT(Said(*device, DeviceEventKind::kNotice),
              Contains(AllOf(HasSubstr("instead of 900000000"), HasSubstr("net.core.rmem_max"))));
}

TEST_F(AravisSettings, FormatsMayChangeFromStreamToStream) {
  StartFullCamera();
  const std::vector<std::pair<std::string, int>> streams = {{"format=Mono8&roi=320x240+0+0", 1},
                                                            {"format=RGB8&roi=64x48+16+8", 3},
                                                            {"format=BayerRG8&binning=2x2", 1},
                                                            {"format=Mono8&roi=320x240+0+0", 1}};
  std::vector<int> channels;
  for (const auto& [options, expected] : streams) {
    const auto device = OpenDriver("aravis:127.0.0.1?fps=20&" + options);
    device->Start();
    const auto frames = Take(*device, 3);
    ASSERT_EQ(frames.size(), 3u) << options;
    for (const Frame& frame : frames) EXPECT_EQ(frame.status, FrameStatus::kComplete) << options;
    channels.push_back(frames.front().image.pixels.channels());
  }
  EXPECT_THAT(channels, ElementsAre(1, 3, 1, 1));
}

}  // namespace
}  // namespace ulf::test::aravis_settings_test
