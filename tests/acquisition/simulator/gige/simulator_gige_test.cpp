// Tests: acquisition/aravis/aravis_exposures, acquisition/simulator/gige/gige_registers,
// acquisition/simulator/gige/simulated_gige_camera, acquisition/simulator/gige/gige_pictures,
// acquisition/simulator/gige/gige_address, commands/camera/simulate_command.
//
// The simulated camera over the wire: opened by the Aravis device like any other, on a loopback of this
// process's own.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/device.h"
#include "acquisition/device/features.h"
#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "core/base/error.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::simulator_gige_test {
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
    options.simulation.width = 160;
    options.simulation.height = 120;
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

TEST_F(GigeSimulator, FramesArriveAsRenderedWithPoses) {
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

TEST_F(GigeSimulator, EveryPixelFormatArrivesAsRendered) {
  GigeServerOptions options = Options();
  options.simulation.noise = true;
  options.simulation.width = 162;  // rows that end within a byte group
  const SimulatedGigeCamera server(options);
  // What the camera's own description offers, so that none is left out.
  std::optional<CameraFeature> described = OpenFeatures("aravis:127.0.0.1")->Find("PixelFormat");
  ASSERT_TRUE(described);
  const std::vector<std::string> offered = described->choices;
  ASSERT_EQ(offered.size(), 20u);
  for (const std::string& name : offered) {
    const auto format = SensorFormatByName(name);
    ASSERT_TRUE(format) << name;
    const auto frames = Take("aravis:127.0.0.1?roi=130x116+32+4&format=" + name, 2);
    const auto poses = ReadPoses(options.poses);
    for (const Frame& frame : frames) {
      const Image& got = frame.image;
      ASSERT_EQ(got.mosaic, PixelsOf(*format).mosaic) << name;
      const double hand_s = poses.at(frame.id).hand_s;
      // The file holds microseconds; the picture's number is in them.
      const Image again = server.camera()
                              .Capture({.open_s = hand_s,
                                        .format = *format,
                                        .id = static_cast<std::uint64_t>(std::llround(hand_s * 1e6))})
                              .image;
      ASSERT_EQ(got.pixels.type(), again.pixels.type()) << name;
      cv::Mat apart;
      cv::absdiff(again.pixels(cv::Rect(32, 4, 130, 116)), got.pixels, apart);
      // Half a microsecond of the hand's way and a float's rounding may tip a number over, not move pixels.
      const int step = 65536 >> std::min(12, PixelsOf(*format).bits);
      const int tipped = got.pixels.depth() == CV_8U ? 1 : step;
      EXPECT_LE(cv::countNonZero(apart.reshape(1) > tipped), 5) << name;
      EXPECT_GT(cv::mean(got.pixels)[0], got.pixels.depth() == CV_8U ? 4 : 1000) << name;
    }
  }
}

TEST_F(GigeSimulator, ServesTwoCamerasAtOnce) {
  GigeServerOptions options = Options(), other_options = Options();
  other_options.interface = "127.0.0.2";
  other_options.serial = "ULF-SIM-2";
  other_options.simulation.seed = 8;
  other_options.poses = scratch_ / "poses2.txt";
  const SimulatedGigeCamera one(options), two(other_options);
  const auto a = OpenDevice("aravis:ULF-SIM-1?format=Mono8"), b = OpenDevice("aravis:ULF-SIM-2?format=Mono8");
  a->Start();
  b->Start();
  std::vector<Frame> from_a, from_b;
  for (int tries = 0; tries < 200 && (from_a.size() < 10 || from_b.size() < 10); ++tries) {
    if (auto frame = a->Next(200ms)) from_a.push_back(std::move(*frame));
    if (auto frame = b->Next(200ms)) from_b.push_back(std::move(*frame));
  }
  a->Stop();
  b->Stop();
  ASSERT_GE(std::min(from_a.size(), from_b.size()), 10u);
  const auto poses_a = ReadPoses(options.poses), poses_b = ReadPoses(other_options.poses);
  const WrittenPose& pose_a = poses_a.at(from_a.back().id);
  const WrittenPose& pose_b = poses_b.at(from_b.back().id);
  EXPECT_NEAR(pose_a.timestamp_s, from_a.back().device_time_s, 1e-5);
  EXPECT_NEAR(pose_b.timestamp_s, from_b.back().device_time_s, 1e-5);
  EXPECT_GT((pose_a.world_from_cam.translation - pose_b.world_from_cam.translation).norm(), 1e-4)
      << "another hand";
}

TEST_F(GigeSimulator, SendsPartOfTheSensor) {
  const SimulatedGigeCamera server(Options());
  const Frame part = Take("aravis:127.0.0.1?format=Mono8&roi=80x60+40+30", 2).back();
  EXPECT_EQ(part.image.width(), 80);
  EXPECT_EQ(part.image.height(), 60);
}

TEST_F(GigeSimulator, TimeRunsOnlyWhileStreaming) {
  GigeServerOptions options = Options();
  options.simulation.fps = 10;
  const SimulatedGigeCamera server(options);
  const auto before = Take("aravis:127.0.0.1?format=Mono8", 12);
  std::this_thread::sleep_for(1500ms);
  const auto after = Take("aravis:127.0.0.1?format=Mono8", 5);
  const auto poses = ReadPoses(options.poses);
  const auto hand_s = [&](const Frame& frame) { return poses.at(frame.id).hand_s; };
  // The very first frame is sent at once, not at a multiple of the period; a busy machine may be one behind.
  EXPECT_NEAR(hand_s(before.back()) - hand_s(before[1]),
              before.back().device_time_s - before[1].device_time_s, 0.12);
  EXPECT_GT(after.front().device_time_s - before.back().device_time_s, 1.4);
  EXPECT_LT(hand_s(after.front()) - hand_s(before.back()), 1.0) << "the hand waited";
}

TEST_F(GigeSimulator, ALoopKeepsAnyPace) {
  GigeServerOptions options = Options();
  options.simulation.fps = 100;
  options.simulation.format = SensorFormat::kMono8;
  options.loop = 5;
  const SimulatedGigeCamera server(options);
  const auto frames = Take("aravis:127.0.0.1?format=Mono8&queue=60", 60);
  const auto poses = ReadPoses(options.poses);
  std::set<double> moments;
  for (const Frame& frame : frames) {
    const double hand_s = poses.at(frame.id).hand_s;
    moments.insert(hand_s);
    EXPECT_LT(hand_s, 0.05);
    const Frame again = server.camera().Capture(
        {.open_s = hand_s, .format = SensorFormat::kMono8, .id = static_cast<std::uint64_t>(hand_s * 1e6)});
    cv::Mat apart;
    cv::absdiff(again.image.pixels, frame.image.pixels, apart);
    EXPECT_LE(cv::countNonZero(apart > 1), 5) << frame.id;
  }
  EXPECT_EQ(moments.size(), 5u);
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

// Calibration practised over the network: the board of the sheet before a lens that is known.
TEST_F(GigeSimulator, CommandHoldsABoardBeforeTheCamera) {
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_NE(binary, nullptr) << "run through ctest";
  const std::string truth = (scratch_ / "truth.json").string(), found = (scratch_ / "found.json").string();
  test::ChildProcess command({binary, "simulate", "--board", "aprilgrid:6x6:30:9", "--calibration-out", truth,
                              "--fps", "8", "--options", "lens=barrel&width=480&height=360"});
  ASSERT_THAT(command.ReadUntil("serving", 30), HasSubstr("serving aravis:ULF-ULF-SIM-1 at 127.0.0.1"));
  EXPECT_EQ(ReadCalibration(truth), SimulatedLens("barrel", 480, 360));
  test::ChildProcess calibrate(
      {binary, "calibrate", "aravis:127.0.0.1", "--board", "aprilgrid:6x6:30:9", "-o", found});
  // A dozen places; all of them would take a minute. Then it calibrates from what it has.
  std::this_thread::sleep_for(std::chrono::seconds(15));
  calibrate.Signal(SIGINT);
  EXPECT_EQ(calibrate.Wait(60), 0);
  command.Signal(SIGTERM);
  EXPECT_EQ(command.Wait(5), 0);
  ASSERT_TRUE(std::filesystem::exists(found));
  EXPECT_NEAR(ReadCalibration(found).fx, 0.875 * 480, 10);
  EXPECT_EQ(test::RunUlf("simulate --board charuco:7 --duration-s 1").exit_code, 2);
}

TEST_F(GigeSimulator, CommandServesManyCamerasWithFaults) {
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_NE(binary, nullptr) << "run through ctest";
  const std::string poses = (scratch_ / "a.txt").string() + "," + (scratch_ / "b.txt").string();
  test::ChildProcess command({binary, "simulate", "wall", "--interface", "127.0.0.1,127.0.0.2", "--seed",
                              "3,4", "--serial", "LEFT,RIGHT", "--poses", poses, "--fault", "lost=0.02",
                              "--fault", "doubled=0.01", "--fps", "20", "--options",
                              "width=320&height=240&fault=drift=1"});
  ASSERT_THAT(command.ReadUntil("ULF-RIGHT", 30), HasSubstr("serving aravis:ULF-LEFT at 127.0.0.1"));
  for (const char* uri : {"aravis:127.0.0.1?packet_size=1400", "aravis:127.0.0.2?packet_size=1400"})
    Take(uri, 5);
  EXPECT_FALSE(ReadPoses(scratch_ / "a.txt").empty());
  EXPECT_FALSE(ReadPoses(scratch_ / "b.txt").empty());
  command.Signal(SIGHUP);
  const std::string figures = command.ReadUntil("RIGHT: served", 5);
  EXPECT_THAT(figures, HasSubstr("LEFT: served"));
  EXPECT_THAT(figures, HasSubstr("asked again in"));
  EXPECT_EQ(command.Wait(5), 0);
  for (const char* wrong :
       {"--fault lots=1", "--fault lost=2", "--fault freeze=3", "--interface 127.0.0.1,127.0.0.2 --seed 3",
        "--fault incomplete=0.1", "--loop 5 --fault drift=1", "--interface 10.9.8.7 --fault lost=0.1"})
    EXPECT_EQ(test::RunUlf(std::string("simulate wall ") + wrong).exit_code, 2) << wrong;
}

bool LoopbackHas(const std::string& address) {
  for (const NetworkInterface& interface : NetworkInterfaces())
    if (interface.address == address) return true;
  return false;
}

TEST_F(GigeSimulator, TakesOverOrRemovesStaleAddresses) {
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_NE(binary, nullptr) << "run through ctest";
  const auto serve = [&](const std::string& address) {
    auto command = std::make_unique<test::ChildProcess>(std::vector<std::string>{
        binary, "simulate", "wall", "--interface", address, "--options", "width=64&height=48"});
    EXPECT_THAT(command->ReadUntil("serving", 30), HasSubstr("at " + address));
    return command;
  };
  const auto living = serve("127.0.0.21");
  serve("127.0.0.22")->Kill();
  ASSERT_TRUE(LoopbackHas("127.0.0.22")) << "else the test shows nothing";
  auto next = serve("127.0.0.22");
  next->Signal(SIGTERM);
  EXPECT_EQ(next->Wait(10), 0);
  EXPECT_FALSE(LoopbackHas("127.0.0.22")) << "taken over, and removed at its end";
  serve("127.0.0.22")->Kill();
  ASSERT_TRUE(LoopbackHas("127.0.0.22"));
  next = serve("127.0.0.23");
  EXPECT_FALSE(LoopbackHas("127.0.0.22")) << "removed by another";
  EXPECT_TRUE(LoopbackHas("127.0.0.21")) << "somebody lives there";
  EXPECT_TRUE(QueryGigeCamera("127.0.0.21", std::chrono::seconds(2)));
}

TEST_F(GigeSimulator, NextRunRemovesAStaleAddress) {
  const auto is_there = [](const std::string& address) {
    const std::vector<NetworkInterface> interfaces = NetworkInterfaces();
    return std::any_of(interfaces.begin(), interfaces.end(),
                       [&](const NetworkInterface& own) { return own.address == address; });
  };
  const auto serve = [](const std::string& address) {
    auto process = std::make_unique<test::ChildProcess>(
        std::vector<std::string>{std::getenv("ULF_BINARY"), "simulate", "wall", "--interface", address,
                                 "--options", "width=160&height=120"});
    EXPECT_THAT(process->ReadUntil("serving", 60), HasSubstr("serving")) << address;
    return process;
  };
  ASSERT_FALSE(is_there("127.0.0.21"));
  serve("127.0.0.21")->Kill();
  ASSERT_TRUE(is_there("127.0.0.21")) << "nothing was left: the test shows nothing";
  {
    const auto again = serve("127.0.0.21");
    EXPECT_TRUE(QueryGigeCamera("127.0.0.21", 2s)) << "the address that was left serves";
    again->Signal(SIGINT);
    EXPECT_EQ(again->Wait(20), 0);
    EXPECT_FALSE(is_there("127.0.0.21")) << "and is its own to take away";
  }
  serve("127.0.0.21")->Kill();
  ASSERT_TRUE(is_there("127.0.0.21"));
  const auto other = serve("127.0.0.22");
  EXPECT_FALSE(is_there("127.0.0.21")) << "of one that is gone";
  const auto beside = serve("127.0.0.23");
  EXPECT_TRUE(is_there("127.0.0.22")) << "of one that lives";
  EXPECT_TRUE(QueryGigeCamera("127.0.0.22", 2s));
  EXPECT_TRUE(QueryGigeCamera("127.0.0.23", 2s));
  for (const auto& process : {other.get(), beside.get()}) {
    process->Signal(SIGINT);
    EXPECT_EQ(process->Wait(20), 0);
  }
  EXPECT_FALSE(is_there("127.0.0.22"));
  EXPECT_FALSE(is_there("127.0.0.23"));
}

// With chunk data, by which the camera says which frame has which exposure, its sequencer takes them;
// without, each time is set and the frames on their way are let pass.
TEST_F(GigeSimulator, RequestedExposuresComeWithTheirLight) {
  GigeServerOptions options = Options();
  options.simulation.exposure_s = 0.004;
  const SimulatedGigeCamera camera(options);
  for (const char* chunks : {"&chunks=on", ""}) {
    const auto device = OpenDevice(std::string("aravis:127.0.0.1?exposure_us=4000&format=Mono16") + chunks);
    device->Start();
    ASSERT_TRUE(device->Next(2000ms));
    ASSERT_EQ(device->TakesExposures(), *chunks ? ExposureRequests::kSequencer : ExposureRequests::kSetTime);
    ASSERT_EQ(device->RequestExposures({-2, 1}), StillRequest::kAsked);
    EXPECT_EQ(device->RequestExposures({-2}), StillRequest::kBusy);
    double bright = 0;  // of the exposure before
    std::vector<double> stops, told_s, brightness;
    for (int tries = 0; tries < 100 && (stops.size() < 2 || bright == 0); ++tries) {
      const auto frame = device->Next(500ms);
      if (!frame || frame->status != FrameStatus::kComplete) continue;
      const double mean = cv::mean(frame->image.pixels)[0];
      if (frame->asked_stops) {
        stops.push_back(*frame->asked_stops);
        told_s.push_back(frame->exposure_s);
        brightness.push_back(mean);
      } else if (stops.size() == 2 && std::abs(frame->exposure_s - 0.004) < 1e-5) {
        bright = mean;
      }
    }
    EXPECT_THAT(stops, ::testing::ElementsAre(-2.0, 1.0)) << chunks;
    ASSERT_EQ(told_s.size(), 2u) << chunks;
    EXPECT_NEAR(told_s[0], 0.001, 1e-5);
    EXPECT_NEAR(told_s[1], 0.008, 1e-5);
    ASSERT_GT(bright, 0) << "the exposure before is set again" << chunks;
    EXPECT_NEAR(brightness[0] / bright, 0.25, 0.03) << chunks;
    EXPECT_NEAR(brightness[1] / bright, 2, 0.25) << chunks;
    device->Stop();
  }
}

// A program that was killed between the exposures of a bracket leaves the sequencer running.
TEST_F(GigeSimulator, StopsASequencerLeftRunning) {
  const SimulatedGigeCamera camera(Options());
  OpenFeatures("aravis:127.0.0.1")->Set("SequencerMode", "On");
  ASSERT_EQ(OpenFeatures("aravis:127.0.0.1")->Find("SequencerMode")->value, "On");
  const auto device = OpenDevice("aravis:127.0.0.1?exposure_us=4000");
  EXPECT_EQ(OpenFeatures("aravis:127.0.0.1")->Find("SequencerMode")->value, "Off");
}

}  // namespace
}  // namespace ulf::simulator_gige_test
