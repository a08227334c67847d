// Tests: acquisition/simulator/gige/gige_transport, acquisition/simulator/gige/gvsp_sender,
// acquisition/simulator/gige/pose_file, acquisition/simulator/gige/genicam_description,
// acquisition/aravis/aravis_clock, acquisition/aravis/aravis_link, acquisition/aravis/aravis_frames.
//
// What the simulated camera sends beside its pictures: chunk data, packets with pauses between them, a
// throughput of its own, times by a clock that IEEE 1588 sets. Opened by the Aravis device like any other
// camera.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "acquisition/device/device.h"
#include "acquisition/link/link_facts.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/pose_file.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::simulator_transport_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class SimulatedTransport : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::optional<std::string> why_not = test::EnterLoopbackNamespace();
    if (why_not) GTEST_SKIP() << *why_not;
  }

  void Serve(const SimulatedClock& clock = {}, const std::string& fault = "") {
    GigeServerOptions options;
    options.simulation.width = 160;
    options.simulation.height = 120;
    options.simulation.fps = 40;
    options.simulation.noise = false;
    options.loop = 8;
    options.clock = clock;
    if (!fault.empty()) options.simulation.faults.Add(fault);
    server_ = std::make_unique<SimulatedGigeCamera>(options);
  }

  static std::unique_ptr<Device> Open(const std::string& options) {
    auto device = OpenDevice("aravis:127.0.0.1?format=Mono8&" + options);
    device->Start();
    return device;
  }

  static std::vector<Frame> WholeFrames(Device& device, std::size_t count) {
    std::vector<Frame> frames;
    for (int tries = 0; tries < 100 && frames.size() < count; ++tries)
      if (auto frame = device.Next(200ms); frame && frame->status == FrameStatus::kComplete)
        frames.push_back(std::move(*frame));
    EXPECT_EQ(frames.size(), count);
    return frames;
  }

  static std::vector<std::string> Notices(Device& device) {
    std::vector<std::string> texts;
    for (const DeviceEvent& event : device.TakeEvents()) texts.push_back(event.text);
    return texts;
  }

  static double TransportOf(const Device& device, TransportFigure figure) {
    return acquisition::FigureIn(device.Statistics().transport, figure).value_or(std::nan(""));
  }

  std::unique_ptr<SimulatedGigeCamera> server_;
};

TEST_F(SimulatedTransport, ChunkDataReachTheFrames) {
  Serve();
  for (const char* format : {"Mono8", "BayerRG12p"}) {
    auto device =
        OpenDevice(std::string("aravis:127.0.0.1?chunks=on&exposure_us=3000&gain_db=6&format=") + format);
    device->Start();
    const std::vector<Frame> frames = WholeFrames(*device, 6);
    ASSERT_FALSE(frames.empty());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const Frame& frame = frames[i];
      EXPECT_DOUBLE_EQ(frame.exposure_s, 0.003);
      EXPECT_NEAR(frame.gain, std::pow(10, 6 / 20.0), 1e-9);
      ASSERT_TRUE(frame.told_id);
      EXPECT_EQ(*frame.told_id, *frames[0].told_id + i) << "the camera's own count";
      ASSERT_TRUE(frame.line_status);
      EXPECT_LE(*frame.line_status, 1u);
      EXPECT_NEAR(frame.device_time_s, frame.host_time_s, 1);
      EXPECT_EQ(frame.image.pixels.size(), cv::Size(160, 120));
    }
    EXPECT_EQ(device->Statistics().incomplete, 0u);
    EXPECT_THAT(Notices(*device), Not(Contains(HasSubstr("chunk"))));
  }
  // The same eight pictures, to and fro, with chunk data and without. A busy machine passes some over, so
  // that the hand may have to come by several times.
  const cv::Mat with = WholeFrames(*Open("chunks=on"), 1).at(0).image.pixels;
  const auto without = Open("chunks=off");
  std::vector<double> differences;
  do {
    differences.push_back(cv::norm(with, WholeFrames(*without, 1).at(0).image.pixels, cv::NORM_INF));
  } while (differences.size() < 16 || (differences.size() < 160 && differences.back() > 0));
  EXPECT_THAT(differences, Contains(0)) << "pixel by pixel";
  EXPECT_THAT(differences, Contains(::testing::Gt(0))) << "the hand moves on";
}

TEST_F(SimulatedTransport, UsesACameraWithoutItsChunks) {
  Serve({.forgets_chunks = true});
  const auto device = Open("chunks=on&exposure_us=3000");
  for (const Frame& frame : WholeFrames(*device, 5)) {
    EXPECT_DOUBLE_EQ(frame.exposure_s, 0.003);
    EXPECT_FALSE(frame.told_id);
    EXPECT_FALSE(frame.line_status);
  }
  EXPECT_EQ(device->Statistics().incomplete, 0u);
  EXPECT_THAT(Notices(*device), Contains(HasSubstr("frames contain none")));
}

// Twenty packets with pauses of two milliseconds are not through before forty have passed.
TEST_F(SimulatedTransport, PacketsArePausedAsAsked) {
  Serve();
  const auto fps = [&](const std::string& options) {
    const auto device = Open(options + "&packet_size=1000");
    WholeFrames(*device, 3);
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t count = WholeFrames(*device, 12).size();
    EXPECT_EQ(device->Statistics().incomplete + device->Statistics().missing, 0u);
    EXPECT_EQ(fmt::format("packet_delay_ns={:.0f}", TransportOf(*device, TransportFigure::kPacketDelayNs)),
              options);
    EXPECT_THAT(Notices(*device), Not(Contains(HasSubstr("packet_delay"))));
    return static_cast<double>(count) / SecondsSince(begin);
  };
  const double at_least = test::kIsSanitized ? 10 : 20;
  EXPECT_GT(fps("packet_delay_ns=0"), at_least);
  const double paused = fps("packet_delay_ns=2000000");
  EXPECT_LT(paused, 25);
  EXPECT_GT(paused, 10);
  EXPECT_GT(fps("packet_delay_ns=0"), at_least) << "and not after it was set back";
}

TEST_F(SimulatedTransport, CameraHoldsItsThroughputLimit) {
  Serve();
  EXPECT_THROW(Open("throughput_limit=10"), Refusal);
  {
    const auto device = Open("throughput_limit=1000000");  // 52 frames of 19,200 bytes; headers take some
    WholeFrames(*device, 20);
    EXPECT_EQ(TransportOf(*device, TransportFigure::kThroughputLimit), 1e6);
  }
  const auto device = Open("throughput_limit=1000000&fps=200");
  WholeFrames(*device, 5);
  const auto begin = std::chrono::steady_clock::now();
  const std::size_t count = WholeFrames(*device, 30).size();
  const double fps = static_cast<double>(count) / SecondsSince(begin);
  EXPECT_LT(fps, 56);
  EXPECT_GT(fps, 25);
  EXPECT_EQ(device->Statistics().missing, 0u) << "frames that were not taken have no number";
}

TEST_F(SimulatedTransport, TimesAreByThePtpClock) {
  Serve({.ahead_s = 1000, .ptp_lock_s = 0.4});
  {
    const auto device = Open("ptp=off");
    const Frame frame = WholeFrames(*device, 1).at(0);
    EXPECT_NEAR(frame.device_time_s - frame.host_time_s, 1000, 1) << "its own clock";
    EXPECT_FALSE(frame.on_shared_clock);
    EXPECT_TRUE(std::isnan(TransportOf(*device, TransportFigure::kClockShared)));
  }
  const auto begin = std::chrono::steady_clock::now();
  const auto device = Open("ptp=on");
  EXPECT_GE(SecondsSince(begin), 0.4) << "opening waits for the lock";
  const std::vector<Frame> frames = WholeFrames(*device, 5);
  for (const Frame& frame : frames) {
    EXPECT_NEAR(frame.device_time_s, frame.host_time_s, 1);
    EXPECT_TRUE(frame.on_shared_clock);
  }
  EXPECT_THAT(Notices(*device),
              Contains(AllOf(HasSubstr("follows an IEEE 1588 clock"), HasSubstr("180 ns"))));
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(TransportOf(*device, TransportFigure::kClockShared), 1);
  EXPECT_EQ(TransportOf(*device, TransportFigure::kClockOffsetNs), 180);
}

// The camera is asked once a second. What it says then holds for the frames that follow.
TEST_F(SimulatedTransport, FramesTellLossAndReturnOfMaster) {
  Serve({.ptp_lock_s = 0.2}, "ptp_lost=0.3:1.5");
  const auto device = Open("ptp=on");
  std::vector<bool> changes;
  std::vector<std::string> told;
  double worst_offset_ns = 0;
  const auto begin = std::chrono::steady_clock::now();
  while (SecondsSince(begin) < 10 && changes.size() < 3) {
    const std::optional<Frame> frame = device->Next(200ms);
    if (!frame) continue;
    if (changes.empty() || changes.back() != frame->on_shared_clock)
      changes.push_back(frame->on_shared_clock);
    worst_offset_ns = std::max(worst_offset_ns, TransportOf(*device, TransportFigure::kClockOffsetNs));
    for (std::string& notice : Notices(*device)) told.push_back(std::move(notice));
    EXPECT_NEAR(frame->device_time_s, frame->host_time_s, 1);
  }
  EXPECT_THAT(changes, ::testing::ElementsAre(true, false, true));
  for (std::string& notice : Notices(*device)) told.push_back(std::move(notice));
  std::erase_if(told, [](const std::string& notice) { return notice.find("1588") == std::string::npos; });
  EXPECT_THAT(told, ::testing::ElementsAre(HasSubstr("follows an IEEE 1588 clock after"),
                                           AllOf(HasSubstr("no longer follows"), HasSubstr("Listening")),
                                           HasSubstr("again (Slave)")));
  EXPECT_GT(worst_offset_ns, 5000) << "twenty microseconds a second";
}

TEST_F(SimulatedTransport, MissingPtpMasterNamesAProgram) {
  Serve({.ptp_lock_s = -1});
  EXPECT_THAT([&] { Open("ptp=on&ptp_wait_s=0.3"); },
              testing::ThrowsMessage<Error>(
                  AllOf(HasSubstr("Listening"), HasSubstr("ptp4l"), HasSubstr("ptp_wait_s"))))
      << "opened";
  EXPECT_NO_THROW(Open("ptp=off"));
}

// From the wire to the journal.
TEST_F(SimulatedTransport, ChunkDataStandInTheViews) {
  const test::ScratchFolder scratch;
  Serve({.ahead_s = 1000, .ptp_lock_s = 0.2});
  const auto device = Open("chunks=on&ptp=on&exposure_us=3000&gain_db=6");
  const Frame frame = WholeFrames(*device, 1).at(0);
  {
    CaptureHeader header;
    header.camera = server_->camera().camera();
    LightFieldWriter writer = LightFieldWriter::Create(scratch / "field", header);
    writer.AddView(frame, View{});
    writer.Close(1);
  }
  const LightField read = ReadLightField(scratch / "field");
  ASSERT_EQ(read.views.size(), 1u);
  const View& view = read.views[0];
  EXPECT_EQ(view.frame_id, frame.told_id);
  EXPECT_EQ(view.line_status, frame.line_status);
  EXPECT_TRUE(view.on_shared_clock);
  EXPECT_NEAR(view.device_time_s, view.host_time_s, 1);
  EXPECT_DOUBLE_EQ(view.exposure_s, 0.003);
  EXPECT_NEAR(view.gain, std::pow(10, 0.3), 1e-9);
}

TEST(PoseFile, AFullDiskIsToldForEachPose) {
  PoseFile file("/dev/full", "studio");
  Frame frame;
  frame.known_cam_from_world = Rigid3{};
  for (std::uint64_t i = 0; i < 2000; ++i) ASSERT_FALSE(file.Write(i, i, frame, 0)) << i;
}

}  // namespace
}  // namespace ulf::simulator_transport_test
