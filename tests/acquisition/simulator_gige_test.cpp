// The simulated camera over the wire: opened by the Aravis device like any other, on a loopback of this
// process's own.
#include <gmock/gmock.h>
#include <signal.h>

#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/simulator/simulated_gige_camera.h"
#include "tests/support/child_process.h"
#include "tests/support/loopback_namespace.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class GigeSimulator : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::optional<std::string> why_not = test::EnterLoopbackNamespace();
    if (why_not) GTEST_SKIP() << *why_not;
  }

  GigeServerOptions Options() {
    GigeServerOptions options;
    options.simulation.width = 320;
    options.simulation.height = 240;
    options.simulation.fps = 20;
    options.simulation.noise = false;
    options.poses = scratch_ / "poses.txt";
    return options;
  }

  test::ScratchFolder scratch_;
};

std::vector<Frame> Take(const std::string& uri, std::size_t count) {
  const auto device = OpenDevice(uri);
  device->Start();
  std::vector<Frame> frames;
  for (int tries = 0; tries < 200 && frames.size() < count; ++tries) {
    auto frame = device->Next(200ms);
    if (frame && frame->status == FrameStatus::kComplete) frames.push_back(std::move(*frame));
  }
  device->Stop();
  EXPECT_EQ(frames.size(), count) << uri;
  return frames;
}

struct WrittenPose {
  double hand_s = 0, timestamp_s = 0;
  Rigid3 world_from_cam;
};

// Frame ids from the comments; the lines between them are plain TUM.
std::map<std::uint64_t, WrittenPose> ReadPoses(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::map<std::uint64_t, WrittenPose> poses;
  std::uint64_t id = 0;
  double hand_s = 0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string first, second, third;
    if (line.starts_with("# frame")) {
      words >> first >> second >> id >> third >> hand_s;
    } else if (!line.starts_with("#")) {
      WrittenPose pose;
      pose.hand_s = hand_s;
      Eigen::Quaterniond& q = pose.world_from_cam.rotation;
      Eigen::Vector3d& t = pose.world_from_cam.translation;
      words >> pose.timestamp_s >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
      EXPECT_FALSE(words.fail()) << line;
      EXPECT_TRUE((words >> first).fail()) << "eight numbers a line: " << line;
      poses[id] = pose;
    }
  }
  return poses;
}

TEST_F(GigeSimulator, FramesArriveAsRenderedAndTheirPosesStandInTheFile) {
  const SimulatedGigeCamera server(Options());
  const auto frames = Take("aravis:127.0.0.1?format=RGB8", 12);
  const auto poses = ReadPoses(scratch_ / "poses.txt");
  double last_hand_s = -1;
  for (const Frame& frame : frames) {
    const auto found = poses.find(frame.id);
    ASSERT_NE(found, poses.end()) << "frame " << frame.id;
    const WrittenPose& pose = found->second;
    EXPECT_NEAR(pose.timestamp_s, frame.device_time_s, 1e-5) << "as the client sees it";
    EXPECT_GT(pose.hand_s, last_hand_s);
    last_hand_s = pose.hand_s;
    // Rendered again here from what the file says, the picture must be the same.
    const Frame again =
        server.camera().Capture({.open_s = pose.hand_s, .exposure_s = 0.005, .format = SensorFormat::kRgb8});
    const Rigid3 difference = *again.known_cam_from_world * pose.world_from_cam;
    EXPECT_LT(difference.translation.norm(), 1e-7);
    EXPECT_LT(RotationAngle(difference.rotation), 1e-7);
    cv::Mat apart;
    cv::absdiff(again.image.pixels, frame.image.pixels, apart);
    EXPECT_LE(cv::countNonZero(apart.reshape(1) > 1), 5) << "frame " << frame.id;
  }
}

TEST_F(GigeSimulator, ExposureGainAndFormatActOnThePicture) {
  const SimulatedGigeCamera server(Options());
  const auto mean = [](const Frame& frame) { return cv::mean(frame.image.pixels)[0]; };
  const Frame plain = Take("aravis:127.0.0.1?format=Mono8&exposure_us=1000&gain_db=0", 2).back();
  const Frame longer = Take("aravis:127.0.0.1?format=Mono8&exposure_us=2000&gain_db=0", 2).back();
  const Frame louder = Take("aravis:127.0.0.1?format=Mono8&exposure_us=1000&gain_db=6.0", 2).back();
  EXPECT_GT(mean(plain), 4);
  EXPECT_NEAR(mean(longer) / mean(plain), 2, 0.1);
  EXPECT_NEAR(mean(louder) / mean(plain), 1.995, 0.1);
  EXPECT_NEAR(longer.exposure_s, 0.002, 1e-9);
  EXPECT_NEAR(louder.gain, 1.995, 0.01);
  const Frame mosaic = Take("aravis:127.0.0.1?format=BayerRG8&exposure_us=5000&gain_db=0", 2).back();
  EXPECT_EQ(mosaic.image.mosaic, Mosaic::kRggb);
  const Frame color = Take("aravis:127.0.0.1?format=RGB8&exposure_us=5000&gain_db=0", 2).back();
  EXPECT_EQ(color.image.pixels.type(), CV_8UC3);
  // The same scene a moment apart: channel means agree, and are in the same order.
  const cv::Scalar from_mosaic = cv::mean(LinearFloat(mosaic.image)),
                   from_color = cv::mean(LinearFloat(color.image));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(from_mosaic[c], from_color[c], 0.02) << c;
  EXPECT_GT(std::abs(from_color[2] - from_color[0]), 0.01) << "red and blue could be told apart";
}

TEST_F(GigeSimulator, PartOfTheSensor) {
  const SimulatedGigeCamera server(Options());
  const Frame part = Take("aravis:127.0.0.1?format=Mono8&roi=160x120+80+60", 2).back();
  EXPECT_EQ(part.image.width(), 160);
  EXPECT_EQ(part.image.height(), 120);
}

TEST_F(GigeSimulator, TimeIsRealWhileSomebodyStreamsAndRestsOtherwise) {
  GigeServerOptions options = Options();
  options.simulation.fps = 10;
  const SimulatedGigeCamera server(options);
  const auto before = Take("aravis:127.0.0.1?format=Mono8", 5);
  std::this_thread::sleep_for(1500ms);
  const auto after = Take("aravis:127.0.0.1?format=Mono8", 5);
  const auto poses = ReadPoses(options.poses);
  const auto hand_s = [&](const Frame& frame) { return poses.at(frame.id).hand_s; };
  // The very first frame is sent at once, not at a multiple of the period.
  EXPECT_NEAR(hand_s(before.back()) - hand_s(before[1]),
              before.back().device_time_s - before[1].device_time_s, 0.02);
  EXPECT_GT(after.front().device_time_s - before.back().device_time_s, 1.4);
  EXPECT_LT(hand_s(after.front()) - hand_s(before.back()), 1.0) << "the hand waited";
}

TEST_F(GigeSimulator, RefusesWhatWouldFailSilently) {
  const GigeServerOptions options = Options();
  const SimulatedGigeCamera server(options);
  const auto refused = [&](const std::string& interface, const std::string& serial) -> std::string {
    GigeServerOptions other = options;
    other.interface = interface;
    other.serial = serial;
    try {
      const SimulatedGigeCamera second(other);
    } catch (const Error& error) {
      return error.what();
    }
    return "not refused";
  };
  EXPECT_THAT(refused("127.0.0.1", "OTHER"), HasSubstr("ULF-SIM-1"));
  EXPECT_THAT(refused("10.1.2.3", "OTHER"), HasSubstr("10.1.2.3"));
  EXPECT_THAT(refused("lo", "OTHER"), HasSubstr("IPv4"));
  EXPECT_THAT(refused("127.0.0.1", "A-SERIAL-THAT-IS-TOO-LONG"), HasSubstr("15"));
}

TEST_F(GigeSimulator, CommandServesUntilASignal) {
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_NE(binary, nullptr) << "run through ctest";
  const std::string calibration = (scratch_ / "camera.json").string();
  test::ChildProcess command({binary, "simulate", "studio", "--fps", "20", "--seed", "3", "--calibration-out",
                              calibration, "--options", "width=320&height=240"});
  ASSERT_THAT(command.ReadUntil("serving", 30), HasSubstr("serving aravis:ULF-ULF-SIM-1 at 127.0.0.1"));
  EXPECT_EQ(ReadCalibration(calibration), SimulatedIntrinsics(320, 240));
  Take("aravis:127.0.0.1", 3);
  command.Signal(SIGTERM);
  EXPECT_THAT(command.ReadUntil("served", 5), HasSubstr("served"));
  EXPECT_EQ(command.Wait(5), 0);
}

}  // namespace
}  // namespace ulf
