// Tests: tracking/sources/outside_pose_source, tracking/sources/pose_history, tracking/sources/poses_spec,
// tracking/sources/pose_stream.
// Poses from outside, with the simulated hand as the truth: a trajectory file with gaps, and a stream that is
// late, out of order, broken and cut. A fault each, and what is kept.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquisition/simulator/hand.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_sources.h"
#include "tracking/sources/pose_stream.h"
#include "tracking/sources/poses_spec.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::outside_poses_test {
namespace {

using ::testing::HasSubstr;

const CameraModel kCamera = CameraModel::Pinhole(64, 48, 60);

const Hand& TestHand() {
  static const Hand hand({.looks_away = false});
  return hand;
}

// Where the camera sits on the tool.
const Rigid3 kToolFromCam{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.6, 0, 0.8))),
                          {0.05, -0.02, 0.11}};
constexpr const char* kHandEyeLine = "0.05 -0.02 0.11 0.08966287954 0 0.11955050606 0.98877107793";

Rigid3 WorldFromTool(double hand_s) {
  return TestHand().CamFromWorld(hand_s).Inverse() * kToolFromCam.Inverse();
}

std::string Line(double time_s, const Rigid3& pose) {
  return fmt::format("{:.9f} {:.12f} {:.12f} {:.12f} {:.12f} {:.12f} {:.12f} {:.12f}\n", time_s,
                     pose.translation.x(), pose.translation.y(), pose.translation.z(), pose.rotation.x(),
                     pose.rotation.y(), pose.rotation.z(), pose.rotation.w());
}

Frame FrameAt(double device_s, double host_s = 0) {
  Frame frame;
  frame.image = {cv::Mat(kCamera.height, kCamera.width, CV_8UC1, cv::Scalar(80)), Transfer::kSrgb};
  frame.device_time_s = device_s;
  frame.host_time_s = host_s;
  return frame;
}

double ErrorMm(const Track& track, double hand_s) {
  return 1000 *
         (track.cam_from_world->OriginInSource() - TestHand().CamFromWorld(hand_s).OriginInSource()).norm();
}

std::uint64_t CountOf(const PoseSource& source, const std::string& name) {
  for (const auto& [key, count] : source.Counts())
    if (key == name) return count;
  ADD_FAILURE() << "no count of " << name;
  return 0;
}

class Sender {
 public:
  explicit Sender(int port, std::uint32_t to = INADDR_LOOPBACK) {
    fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(to);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    connected_ = connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Sender() { close(fd_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  bool Connected() const { return connected_; }
  void Send(const std::string& text) const {
    EXPECT_EQ(send(fd_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  // A line that comes back; empty when none comes in five seconds or the connection is closed.
  std::string Read() const {
    const timeval patience{5, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::string line;
    for (char c = 0; recv(fd_, &c, 1, 0) == 1 && c != '\n';) line += c;
    return line;
  }

 private:
  int fd_ = -1;
  bool connected_ = false;
};

template <typename Condition>
bool Eventually(const Condition& condition) {
  for (int i = 0; i < 1000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

TEST(PoseHistory, InterpolatesPosesAndKnowsGaps) {
  PoseHistory history(0.2);
  Rigid3 pose;
  EXPECT_EQ(history.At(0, &pose), PoseLookup::kAfter);
  const auto turned = [](double angle) {
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())), {angle, 0, 0}};
  };
  history.Add(1.1, turned(0.2));
  history.Add(1.0, turned(0));  // late
  history.Add(2.0, turned(1));
  ASSERT_EQ(history.At(1.05, &pose), PoseLookup::kFound);
  EXPECT_NEAR(pose.translation.x(), 0.1, 1e-12);
  EXPECT_NEAR(RotationAngle(pose.rotation), 0.1, 1e-12);
  EXPECT_EQ(history.At(1.0, &pose), PoseLookup::kFound);
  EXPECT_EQ(history.At(0.9, &pose), PoseLookup::kBefore);
  EXPECT_EQ(history.At(1.5, &pose), PoseLookup::kGap);
  EXPECT_EQ(history.At(2.1, &pose), PoseLookup::kAfter);
}

// A file on another clock, of the tool and not the camera, with half a second missing.
TEST(OutsidePoses, AreReadFromATrajectoryFile) {
  test::ScratchFolder scratch;
  constexpr double kClock = 3.7;
  {
    std::ofstream file(scratch / "robot.txt");
    file << "# time tx ty tz qx qy qz qw\n";
    for (int i = 0; i < 500; ++i)
      if (const double t = i / 100.0; t < 2 || t > 2.5) file << Line(t + kClock, WorldFromTool(t));
    std::ofstream(scratch / "hand_eye.txt") << "# camera in the tool\n" << kHandEyeLine << "\n";
  }
  const auto source =
      PosesSpec::Parse(fmt::format("tum:{}?offset_s={}&hand_eye={}", (scratch / "robot.txt").string(), kClock,
                                   (scratch / "hand_eye.txt").string()))
          .Open(kCamera, {});
  EXPECT_TRUE(source->IsMetric());
  double worst_mm = 0;
  int posed = 0, in_gap = 0;
  for (int i = 0; i < 180; ++i) {
    const double t = 0.013 + i / 30.0;  // to 6 s; the file ends at 5
    const Track track = source->Step(FrameAt(t));
    if (track.cam_from_world) {
      worst_mm = std::max(worst_mm, ErrorMm(track, t));
      ++posed;
      EXPECT_EQ(source->PoseOf(*track.anchor).translation, track.cam_from_world->translation);
    } else {
      in_gap += t < 4;
      EXPECT_EQ(track.state, TrackState::kLost) << t;
    }
  }
  EXPECT_LT(worst_mm, 0.3);
  EXPECT_EQ(in_gap, 15);
  EXPECT_EQ(posed, static_cast<int>(CountOf(*source, "frames_posed")));
  EXPECT_EQ(CountOf(*source, "frames_in_gaps"), 15u);
  EXPECT_EQ(CountOf(*source, "frames_outside"), 180u - 15 - static_cast<unsigned>(posed));
}

TEST(OutsidePoses, RefuseUnreadableFilesAndOptions) {
  test::ScratchFolder scratch;
  const std::string empty = (scratch / "empty.txt").string(), bad = (scratch / "bad.txt").string();
  std::ofstream(empty) << "# nothing\n";
  std::ofstream(bad) << "1 2 3\n";
  EXPECT_THROW(PosesSpec::Parse("tum:" + empty).Open(kCamera, {}), Error);
  EXPECT_THROW(PosesSpec::Parse("tum:/nonexistent").Open(kCamera, {}), Error);
  EXPECT_THROW(PosesSpec::Parse("tum:" + empty + "?hand_eye=" + bad), Error);
  for (const char* text :
       {"tum:x?speed=2", "tcp:port", "tcp:70000", "tcp:5000?clock=sundial", "tcp:5000?wait_s=-1"})
    EXPECT_THROW(PosesSpec::Parse(text), Refusal) << text;
}

struct Streamed {
  explicit Streamed(PoseStreamOptions options) {
    auto made = std::make_unique<PoseStream>(options);
    stream = made.get();
    source = MakeStreamSource(kCamera, std::move(made), kToolFromCam);
  }
  bool Has(std::uint64_t poses) const {
    return Eventually([&] { return stream->Statistics().poses >= poses; });
  }
  PoseStream* stream;
  std::unique_ptr<PoseSource> source;
};

// Poses come 60 ms after their time and in an order that jumps; every frame has its own.
TEST(PoseStreamFaults, LateAndUnorderedPosesAreFound) {
  Streamed s({.clock = SenderClock::kDevice, .wait_s = 20});
  std::thread sending([&] {
    const Sender sender(s.stream->Port());
    constexpr int kOrder[] = {2, 0, 1, 4, 3};
    for (int group = 0; group < 40; ++group) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      for (const int k : kOrder) {
        const double t = (5 * group + k) / 100.0;
        sender.Send(Line(t, WorldFromTool(t)));
      }
    }
    EXPECT_TRUE(Eventually([&] { return s.stream->Statistics().found >= 55; }));
  });
  double worst_mm = 0;
  int posed = 0;
  for (int i = 0; i < 55; ++i) {
    const double t = 0.03 + i / 30.0;
    const Track track = s.source->Step(FrameAt(t));
    if (!track.cam_from_world) continue;
    ++posed;
    worst_mm = std::max(worst_mm, ErrorMm(track, t));
  }
  sending.join();
  EXPECT_EQ(posed, 55);
  EXPECT_LT(worst_mm, 0.5);
  EXPECT_TRUE(s.Has(40 * 5));
  EXPECT_EQ(CountOf(*s.source, "out_of_order"), 40u * 3);
}

// Half a second is missing: its frames have no pose, all others do.
TEST(PoseStreamFaults, AGapLeavesItsFramesWithoutPoses) {
  Streamed s({.clock = SenderClock::kDevice, .wait_s = 0.2});
  const Sender sender(s.stream->Port());
  for (int i = 0; i < 300; ++i)
    if (const double t = i / 100.0; t < 1 || t > 1.5) sender.Send(Line(t, WorldFromTool(t)));
  ASSERT_TRUE(s.Has(249));
  int without = 0;
  for (int i = 0; i < 80; ++i) {
    const double t = 0.013 + i / 30.0;
    const Track track = s.source->Step(FrameAt(t));
    without += !track.cam_from_world;
    EXPECT_EQ(track.cam_from_world.has_value(), t < 0.99 || t > 1.51) << t;
  }
  EXPECT_EQ(CountOf(*s.source, "frames_in_gaps"), static_cast<std::uint64_t>(without));
  EXPECT_EQ(without, 15);
}

// Lines that mean nothing are counted and the first is named; poses between them are kept.
TEST(PoseStreamFaults, UnreadableLinesAreCounted) {
  Streamed s({.clock = SenderClock::kDevice});
  const Sender sender(s.stream->Port());
  sender.Send("# a comment\n\n" + Line(0, WorldFromTool(0)) + "hello robot\n0.1 1 2 3\n0.1 1 2 3 0 0 0 0\n" +
              "0.1 nan 2 3 0 0 0 1\n" + std::string(5000, 'x') + "\n0.1 1 2 3 0 0 0 1 7\n" +
              Line(0.1, WorldFromTool(0.1)));
  ASSERT_TRUE(s.Has(2));
  const auto counts = s.stream->Statistics();
  EXPECT_EQ(counts.malformed, 6u);
  EXPECT_THAT(counts.first_malformed, HasSubstr("line 4: 'hello robot'"));
  EXPECT_TRUE(s.source->Step(FrameAt(0.05)).cam_from_world);
}

// The sender goes: frames pass without a pose and without waiting. It comes back: they have poses again.
TEST(PoseStreamFaults, ASenderMayLeaveAndComeBack) {
  Streamed s({.clock = SenderClock::kDevice, .wait_s = 10});
  {
    const Sender sender(s.stream->Port());
    for (int i = 0; i <= 100; ++i) sender.Send(Line(i / 100.0, WorldFromTool(i / 100.0)));
    ASSERT_TRUE(s.Has(101));
    EXPECT_TRUE(s.source->Step(FrameAt(0.5)).cam_from_world);
    // Meanwhile nobody else can send.
    const Sender second(s.stream->Port());
    EXPECT_THAT(second.Read(), HasSubstr("another sender"));
  }
  ASSERT_TRUE(Eventually([&] { return !s.stream->Connected(); }));
  EXPECT_TRUE(s.source->Step(FrameAt(0.9)).cam_from_world) << "what had come is kept";
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) {
    const Track track = s.source->Step(FrameAt(1.1 + i / 30.0));
    EXPECT_FALSE(track.cam_from_world);
    EXPECT_EQ(track.state, TrackState::kLost);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5)) << "nothing to wait for";
  const Sender again(s.stream->Port());
  for (int i = 200; i <= 300; ++i) again.Send(Line(i / 100.0, WorldFromTool(i / 100.0)));
  ASSERT_TRUE(s.Has(202));
  const Track track = s.source->Step(FrameAt(2.5));
  ASSERT_TRUE(track.cam_from_world);
  EXPECT_TRUE(track.relocalized);
  EXPECT_LT(ErrorMm(track, 2.5), 0.5);
  EXPECT_EQ(CountOf(*s.source, "connections"), 2u);
  EXPECT_EQ(CountOf(*s.source, "refused"), 1u);
  EXPECT_EQ(CountOf(*s.source, "frames_not_in_time"), 20u);
}

// A sender that stays and says nothing costs one wait, not one a frame; and a stop ends it.
TEST(PoseStreamFaults, WaitingIsBoundedAndCanBeStopped) {
  Streamed s({.clock = SenderClock::kDevice, .wait_s = 0.3, .connect_s = 0.3});
  const Sender sender(s.stream->Port());
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(s.source->Step(FrameAt(i / 30.0)).cam_from_world);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));

  std::atomic<bool> stopped = false;
  Streamed waiting({.clock = SenderClock::kDevice, .connect_s = 600, .stop = [&] { return stopped.load(); }});
  std::thread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stopped = true;
  });
  EXPECT_FALSE(waiting.source->Step(FrameAt(0)).cam_from_world);
  stopper.join();
}

// Whoever listens at every address is reached at 127.0.0.2, too.
TEST(PoseStream, ListensOnLoopbackOnly) {
  const PoseStream stream({});
  EXPECT_TRUE(Sender(stream.Port()).Connected());
  EXPECT_FALSE(Sender(stream.Port(), INADDR_LOOPBACK + 1).Connected());
}

TEST(PoseStreamFaults, APortThatIsTakenIsSaid) {
  const PoseStream first({});
  EXPECT_THAT([&] { const PoseStream second({.port = first.Port()}); },
              testing::ThrowsMessage<Error>(HasSubstr("choose another port")))
      << "two on one port";
}

// Three clocks: the camera's, the sender's, ours. Learnt from when things arrive, or found out by the sender.
TEST(PoseStreamClocks, AreSynchronised) {
  constexpr double kSenderAhead = 1234.5, kCameraBehind = 98.25;
  for (const bool handshake : {false, true}) {
    Streamed s({.wait_s = 20});
    const double began_s = EpochSeconds();
    std::atomic<bool> done = false;
    std::thread sending([&] {
      const Sender sender(s.stream->Port());
      if (handshake) {
        double best_trip_s = 1e9, offset_s = 0;
        for (int i = 0; i < 10; ++i) {
          const double sent_s = EpochSeconds() + kSenderAhead;
          sender.Send(fmt::format("sync {:.9f}\n", sent_s));
          double echoed_s = 0, host_s = 0;
          ASSERT_EQ(std::sscanf(sender.Read().c_str(), "sync %lf %lf", &echoed_s, &host_s), 2);
          EXPECT_NEAR(echoed_s, sent_s, 1e-6);
          const double back_s = EpochSeconds() + kSenderAhead;
          if (back_s - sent_s < best_trip_s) {
            best_trip_s = back_s - sent_s;
            offset_s = host_s - 0.5 * (sent_s + back_s);
          }
        }
        sender.Send(fmt::format("offset {:.9f}\n", offset_s));
      }
      while (!done) {
        const double now_s = EpochSeconds();
        sender.Send(Line(now_s + kSenderAhead, WorldFromTool(now_s - began_s)));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
    // Frames that reach us at once. The clocks are learnt from the first second's.
    double worst_mm = 0;
    int posed = 0;
    for (int i = 0; i < 60; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(15));
      const double now_s = EpochSeconds();
      const Track track = s.source->Step(FrameAt(now_s - kCameraBehind, now_s));
      if (i < 30 || !track.cam_from_world) continue;
      ++posed;
      worst_mm = std::max(worst_mm, ErrorMm(track, now_s - began_s));
    }
    done = true;
    sending.join();
    const auto offset_s = s.stream->Statistics().offset_s;
    ASSERT_TRUE(offset_s);
    std::printf("%s: clocks off by %.3f ms, poses by up to %.2f mm, %d of 30 posed\n",
                handshake ? "handshake" : "arrivals", 1000 * (*offset_s + kSenderAhead), worst_mm, posed);
    EXPECT_NEAR(*offset_s, -kSenderAhead, 0.03);
    EXPECT_GE(posed, 20);
    EXPECT_LT(worst_mm, 15);  // the hand moves at 0.3 m/s
  }
}

// As a command: the file is the truth of the same simulated hand.
TEST(OutsidePoses, TrackCommandTakesATrajectoryFile) {
  test::ScratchFolder scratch;
  const std::string poses = (scratch / "poses.txt").string();
  const std::string device = "'sim:studio?width=160&height=120&look_away=0&fps=30'";
  const auto known = test::RunUlf("track " + device + " --frames 40 --poses known -o " + poses);
  ASSERT_EQ(known.exit_code, 0) << known.errors;
  const auto tracked = test::RunUlf("track " + device + " --frames 60 --json --poses tum:" + poses);
  ASSERT_EQ(tracked.exit_code, 0) << tracked.errors;
  const auto report = JsonFromText(tracked.output);
  EXPECT_EQ(report["tracked"], 40);
  EXPECT_EQ(report["poses_from_outside"]["frames_outside"], 20);
  EXPECT_LT(report["ate_live_rmse"].get<double>(), 1e-5);
}

}  // namespace
}  // namespace ulf::outside_poses_test
