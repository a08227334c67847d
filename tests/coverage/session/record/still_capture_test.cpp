// Tests: coverage/session/record/still_capture.
//
// Photographs beside live view: the simulator behind a PTP/IP camera, libgphoto2's own driver, the tracker,
// and a light field of full-resolution photographs.
#include "coverage/session/record/still_capture.h"
#include "core/base/json_text.h"

#include <gmock/gmock.h>

#include <cmath>
#include <condition_variable>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/simulated_camera.h"
#include "commands/capture/capture_report.h"
#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/operator/recorded_pictures.h"
#include "coverage/session/capture_session.h"
#include "tests/support/floors.h"
#include "tests/support/ptpip_camera.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::still_capture_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

std::string Jpeg(const cv::Mat& pixels) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", pixels, bytes, {cv::IMWRITE_JPEG_QUALITY, 92});
  return {bytes.begin(), bytes.end()};
}

std::string BytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::set<std::string> BytesIn(const fs::path& folder) {
  std::set<std::string> contents;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder)) contents.insert(BytesOf(entry.path()));
  return contents;
}

SimulationOptions Simulated(int width, int height) {
  SimulationOptions options;
  options.width = width;
  options.height = height;
  options.cap_azimuth = 24 * M_PI / 180;
  options.cap_elevation = 12 * M_PI / 180;
  options.looks_away = false;
  return options;
}

// A body in the simulated hand. Simulated time goes on with every live frame; a photograph is taken `kLagS`
// later, when the hand has moved on.
class TetheredHand {
 public:
  static constexpr double kLagS = 0.15;

  TetheredHand()
      : live_(Simulated(480, 360)),
        still_(Simulated(960, 640)),
        body_([this] { return LivePicture(); }, [this](int number) { return Photograph(number); },
              {.shutter_lag_s = 0.02}) {}

  const CameraModel& LiveCamera() const { return live_.camera(); }
  const CameraModel& StillCamera() const { return still_.camera(); }
  PtpipCamera& Body() { return body_; }

  // Live view waits for its reader, so that a slow machine sees what a fast one sees.
  void WaitForReader(bool wait) { waits_ = wait; }
  void FrameWasRead() {
    {
      const std::lock_guard lock(mutex_);
      ++read_;
    }
    was_read_.notify_all();
  }
  void SpoilPhotograph(int number) { spoiled_ = number; }
  // Live view begins late, and somebody photographs meanwhile.
  void ShootBeforeLiveView() { refused_ = 3; }

  struct Shot {
    std::string bytes;
    Rigid3 cam_from_world;
  };
  std::map<int, Shot> Shots() const {
    const std::lock_guard lock(mutex_);
    return shots_;
  }

 private:
  std::string LivePicture() {
    if (refused_ > 0) {
      if (refused_-- == 3) body_.PressShutter();
      return "";
    }
    std::uint64_t index = 0;
    {
      std::unique_lock lock(mutex_);
      // The driver throws some live frames away: those are never read.
      if (waits_ && !was_read_.wait_for(lock, milliseconds(400), [&] { return next_ < read_ + 2; }))
        read_ = next_;
      index = next_++;
    }
    return Jpeg(live_.Capture(index).image.pixels);
  }

  std::vector<PtpipFile> Photograph(int number) {
    double now_s = 0;
    {
      const std::lock_guard lock(mutex_);
      now_s = static_cast<double>(next_) / live_.options().fps;
    }
    const Frame frame = still_.Capture(
        {.open_s = now_s + kLagS, .exposure_s = 0.002, .id = 10'000u + static_cast<unsigned>(number)});
    cv::Mat pixels = frame.image.pixels;
    if (number == spoiled_) pixels = cv::Mat(pixels.size(), CV_8UC3, cv::Scalar(40, 90, 120));
    Shot shot{Jpeg(pixels), *frame.known_cam_from_world};
    const std::lock_guard lock(mutex_);
    shots_[number] = shot;
    return {{fmt::format("DSC_{:04}.JPG", number), shot.bytes}};
  }

  SimulatedCamera live_, still_;
  mutable std::mutex mutex_;
  std::condition_variable was_read_;
  std::uint64_t next_ = 0, read_ = 0;
  bool waits_ = true;
  std::atomic<int> spoiled_{0}, refused_{0};
  std::map<int, Shot> shots_;
  PtpipCamera body_;  // last: its threads use the rest
};

class StillCaptureTest : public ::testing::Test {
 protected:
  void SetUp() override { setenv("HOME", (scratch_ / "home").c_str(), 1); }

  CaptureSummary Capture(TetheredHand& hand, const std::map<std::uint64_t, std::function<void()>>& at_frame,
                         std::uint64_t frames, const std::string& more = "") {
    auto device = OpenDevice(hand.Body().Uri() + "?liveview_fps=15&focus=manual&shutter=1/500" + more);
    device->Start();
    CaptureHeader header;
    header.camera = hand.StillCamera();
    CaptureOptions options;
    options.still_camera = hand.StillCamera();
    options.max_frames = frames;
    options.threshold_px = 12;
    CaptureHooks hooks;
    hooks.after_frame = [&](const SharedCaptureState& progress) {
      if (const auto found = at_frame.find(progress->frames); found != at_frame.end()) found->second();
      hand.FrameWasRead();
    };
    const auto look = [this](const SharedCaptureState& now) {
      states_with_views_ += now->recorded_view.has_value();
      if (now->recorded_view) shown_as_new_.insert(*now->recorded_view);
      pictures_.Follow(*now);
    };
    hooks.while_waiting = look;
    hooks.after_frame = [&, then = hooks.after_frame](const SharedCaptureState& now) {
      look(now), then(now);
    };
    const auto poses = MakeTrackerSource(hand.LiveCamera(), {.deterministic = true});
    return RunCapture(*device, hand.LiveCamera(), *poses, LightFieldWriter::Create(Dir(), header), options,
                      hooks);
  }
  fs::path Dir() const { return scratch_ / "lf"; }

  // Every photograph that was taken is in images/ or in unposed/, byte for byte, once.
  static void ExpectNothingLost(const TetheredHand& hand, const fs::path& dir) {
    const auto recorded = BytesIn(dir / "images"), unposed = BytesIn(dir / "unposed");
    for (const auto& [number, shot] : hand.Shots())
      EXPECT_EQ(recorded.count(shot.bytes) + unposed.count(shot.bytes), 1u) << "photograph " << number;
    EXPECT_EQ(recorded.size() + unposed.size(), hand.Shots().size());
  }

  ScratchFolder scratch_;
  // Of the last capture, as its display knows it.
  std::size_t states_with_views_ = 0;
  std::set<int> shown_as_new_;
  RecordedPictures pictures_;
};

#ifndef ULF_LINK_FAULTS
TEST_F(StillCaptureTest, PhotographsHaveTheirOwnPoses) {
  TetheredHand hand;
  std::uint64_t body_releases = 0;
  const CaptureSummary summary =
      Capture(hand,
              {{70, [&] { hand.Body().AnswerBusy(2); }},
               {90, [&] { hand.Body().PressShutter(), ++body_releases; }},
               // A finger comes before an answer that is awaited: both are kept.
               {100, [&] { hand.Body().PressBeforeNextRelease(), ++body_releases; }},
               {91, [&] { hand.SpoilPhotograph(hand.Body().Releases() + 3); }}},
              160);
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kFrames);
  EXPECT_GE(summary.frames, 160u);
  EXPECT_EQ(hand.Body().BusyAnswers(), 2);
  const StillCounts& counts = summary.stills;
  EXPECT_EQ(counts.arrived, hand.Shots().size());
  // The last request may have come too late for the shutter.
  EXPECT_LE(counts.arrived, counts.asked + body_releases);
  EXPECT_GE(counts.arrived + 1, counts.asked + body_releases) << "the one from the body was taken in as well";
  EXPECT_EQ(counts.without_pose, 1u) << "the spoiled one";
  EXPECT_EQ(counts.recorded, summary.recorded);
  EXPECT_EQ(counts.recorded + counts.not_needed + counts.without_pose, counts.arrived);
  EXPECT_GE(counts.recorded, 6u);
  EXPECT_GT(summary.reasons[static_cast<std::size_t>(Reason::kStill)], 0u);
  EXPECT_EQ(summary.reasons[static_cast<std::size_t>(Reason::kRecorded)], 0u) << "no live frame";

  ExpectNothingLost(hand, Dir());
  const LightField light_field = ReadLightField(Dir());
  ASSERT_EQ(light_field.views.size(), counts.recorded);
  ASSERT_EQ(light_field.cameras.size(), 1u);
  EXPECT_EQ(light_field.cameras[0].width, 960);
  std::vector<TimedPose> poses, truth;
  const auto shots = hand.Shots();
  for (const View& view : light_field.views) {
    EXPECT_TRUE(view.image_path.ends_with(".jpg"));
    const std::string bytes = BytesOf(Dir() / view.image_path);
    for (const auto& [number, shot] : shots) {
      if (shot.bytes != bytes) continue;
      poses.push_back({static_cast<double>(number), view.cam_from_world});
      truth.push_back({static_cast<double>(number), shot.cam_from_world});
    }
    EXPECT_DOUBLE_EQ(view.exposure_s, 0.002) << "as set on the camera";
    EXPECT_EQ(ReadViewImage(light_field, view).width(), 960);
  }
  ASSERT_EQ(poses.size(), light_field.views.size());
  const auto error = CompareTrajectories(poses, truth, 0.1);
  ASSERT_TRUE(error);
  RecordProperty("ate_mm", std::to_string(1e3 * error->ate_rmse));
  RecordProperty("recorded", static_cast<int>(counts.recorded));
  EXPECT_LT(error->ate_rmse, 0.005) << "metres, about one metre away";
  EXPECT_LT(error->rotation_rmse_deg, 0.3);
  // The display has each of them, once, and the photograph in place of the live picture.
  EXPECT_EQ(states_with_views_, counts.recorded);
  EXPECT_EQ(shown_as_new_.size(), counts.recorded);
  EXPECT_EQ(pictures_.size(), counts.recorded);
  CaptureState state;
  state.subject = summary.subject;
  state.coverage = summary.map;
  for (const View& view : light_field.views) state.view_ids.push_back(view.id);
  for (const View& view : light_field.views) {
    const auto nearest = pictures_.Nearest(state, view.cam_from_world);
    ASSERT_FALSE(nearest.empty());
    EXPECT_EQ(nearest[0].picture->key, static_cast<std::uint64_t>(view.id));
    cv::Mat photograph;
    cv::resize(ReadRecordedImage(light_field, view).pixels, photograph, {640, 427}, 0, 0, cv::INTER_AREA);
    EXPECT_GT(cv::PSNR(nearest[0].picture->Srgb8(), photograph), 30) << "view " << view.id;
  }
  // And not where the hand was when they were asked for: it moves at more than 10 degrees a second.
  EXPECT_GT(TetheredHand::kLagS * Simulated(1, 1).speed, 0.03);
}

#endif
#ifdef ULF_LINK_FAULTS
TEST_F(StillCaptureTest, DroppedLinkLeavesWhatWasRecorded) {
  TetheredHand hand;
  std::size_t taken_before = 0;
  const CaptureSummary summary = Capture(hand,
                                         {{90,
                                           [&] {
                                             taken_before = hand.Shots().size();
                                             hand.Body().Refuse(true);
                                             hand.Body().DropLink();
                                           }}},
                                         100'000, "&reconnect_s=0");
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kDeviceLost);
  EXPECT_GE(summary.frames, 90u);
  EXPECT_LT(summary.frames, 100u);
  ASSERT_GE(taken_before, 3u);
  const LightField light_field = ReadLightField(Dir());
  EXPECT_EQ(light_field.views.size(), summary.recorded);
  // The last photograph may still have been in the camera.
  EXPECT_GE(summary.stills.arrived + 1, taken_before);
  EXPECT_EQ(BytesIn(Dir() / "images").size() + BytesIn(Dir() / "unposed").size(), summary.stills.arrived);
  EXPECT_GE(summary.recorded, 1u);
}

TEST_F(StillCaptureTest, ALinkThatComesBackGoesOn) {
  TetheredHand hand;
  int taken_before = 0;
  const CaptureSummary summary = Capture(hand,
                                         {{80,
                                           [&] {
                                             taken_before = hand.Body().Releases();
                                             hand.Body().DropLink();
                                           }}},
                                         130);
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kFrames);
  EXPECT_EQ(summary.device.reconnects, 1u) << summary.problem;
  EXPECT_GT(hand.Body().Releases(), taken_before) << "and photographs are taken again";
  const LightField light_field = ReadLightField(Dir());
  EXPECT_EQ(light_field.views.size(), summary.recorded);
  EXPECT_EQ(BytesIn(Dir() / "images").size() + BytesIn(Dir() / "unposed").size(), summary.stills.arrived);
}

#endif
#ifndef ULF_LINK_FAULTS
TEST_F(StillCaptureTest, CommandNeedsAStillCalibration) {
  TetheredHand hand;
  hand.WaitForReader(false);
  const fs::path calibration = scratch_ / "calibration.json";
  WriteCalibration(calibration, hand.LiveCamera(), "3001234", "test");
  hand.ShootBeforeLiveView();
  const std::string uri = hand.Body().Uri() + "?liveview_fps=10&shutter=1/500";
  const std::string command = "capture --no-geometry '" + uri +
                              "' --headless --json --quality fast --frames 90 --calibration " +
                              calibration.string() + " -o ";
  const CommandResult refused = RunUlf(command + (scratch_ / "refused").string());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("--mode still"));
  EXPECT_FALSE(fs::exists(scratch_ / "refused"));
  EXPECT_THAT(BytesIn(scratch_ / "refused.photographs"), ::testing::ElementsAre(hand.Shots().at(1).bytes))
      << "what was photographed before it was refused";

  WriteCalibration(calibration, hand.StillCamera(), "3001234", "test", "still");
  hand.ShootBeforeLiveView();
  const int before = hand.Body().Releases();
  const CommandResult captured = RunUlf(command + (scratch_ / "captured").string() +
                                        " --deterministic --keep-frames " + (scratch_ / "frames").string());
  ASSERT_EQ(captured.exit_code, 0) << captured.errors;
  const auto result = JsonFromText(captured.output);
  EXPECT_GE(result["photographs"]["recorded"].get<int>(), 1) << captured.output;
  const LightField light_field = ReadLightField(scratch_ / "captured");
  EXPECT_EQ(light_field.cameras[0], hand.StillCamera());
  EXPECT_EQ(light_field.views.size(), result["photographs"]["recorded"].get<std::size_t>());
  EXPECT_EQ(light_field.device_serial, "3001234");
  EXPECT_EQ(result["photographs"]["arrived"], hand.Body().Releases() - before);
  EXPECT_EQ(BytesIn(scratch_ / "captured/unposed").count(hand.Shots().at(before + 1).bytes), 1u)
      << "from before the first live frame";

  // The session runs again from what was kept, with the intrinsics that it had, and comes to the same.
  for (const char* name : {"again", "once_more"}) {
    const CommandResult again =
        RunUlf("capture --no-geometry 'replay:" + (scratch_ / "frames").string() +
               "' --headless --json --quality fast --deterministic -o " + (scratch_ / name).string());
    ASSERT_EQ(again.exit_code, 0) << again.errors;
    const auto counts = JsonFromText(again.output)["photographs"];
    for (const char* count : {"arrived", "recorded", "not_needed", "without_pose"})
      EXPECT_EQ(counts[count], result["photographs"][count]) << count;
    EXPECT_EQ(BytesIn(scratch_ / name / "images"), BytesIn(scratch_ / "captured/images"))
        << "the same photographs get poses";
    EXPECT_EQ(BytesIn(scratch_ / name / "unposed"), BytesIn(scratch_ / "captured/unposed"));
  }
  EXPECT_EQ(BytesOf(scratch_ / "again/journal.jsonl"), BytesOf(scratch_ / "once_more/journal.jsonl"));

  // And on, by photographs alone: the map of live view is made of them.
  ASSERT_GE(light_field.views.size(), 3u) << "too few to build a map of";
  const CommandResult resumed = RunUlf(command + (scratch_ / "captured").string() + " --resume");
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_GT(JsonFromText(resumed.output)["tracked"].get<int>(), 30) << resumed.output;
}

// A hand that goes round the subject, 0.3 radians a second, a metre away.
Rigid3 HandAt(double time_s) {
  return LookAt({std::sin(0.3 * time_s), 0, -std::cos(0.3 * time_s)}, {0, 0, 0}, {0, -1, 0});
}

std::vector<LivePose> Trajectory(double from_s, double to_s, const std::function<Rigid3(double)>& hand) {
  std::vector<LivePose> poses;
  for (double t = from_s; t < to_s; t += 1 / 15.0) poses.push_back({t, hand(t), 5});
  return poses;
}

TEST(TimeOnTrajectory, IsWhenTheHandWasThereOrNothing) {
  const auto poses = Trajectory(0, 3, HandAt);
  for (const double t : {0.5, 1.0, 1.23, 2.01, 2.7}) {
    const auto found = TimeOnTrajectory(poses, HandAt(t), 1);
    ASSERT_TRUE(found) << t;
    EXPECT_NEAR(*found, t, 0.004) << t;
  }
  EXPECT_FALSE(TimeOnTrajectory(poses, HandAt(-0.5), 1)) << "before the first";
  EXPECT_FALSE(TimeOnTrajectory(poses, HandAt(3.5), 1)) << "behind the last";
  EXPECT_FALSE(TimeOnTrajectory(Trajectory(0, 3, [](double) { return HandAt(1); }), HandAt(1), 1))
      << "a hand that stands still tells no time";
  const auto to_and_fro = Trajectory(0, 4, [](double t) { return HandAt(t < 2 ? t : 4 - t); });
  EXPECT_FALSE(TimeOnTrajectory(to_and_fro, HandAt(1), 1)) << "it was there twice";
  EXPECT_FALSE(TimeOnTrajectory({}, HandAt(1), 1));
}

// Photographs lie where they say; remembers where they were looked for.
class RememberingPoses : public PoseSource {
 public:
  Track Step(const Frame&) override { return {}; }
  std::optional<Track> Locate(const Frame& photograph, const CameraModel&,
                              const std::optional<Rigid3>& near) const override {
    looked_for = near;
    Track track;
    track.state = TrackState::kTracking;
    track.cam_from_world = photograph.known_cam_from_world;
    return track;
  }
  Rigid3 PoseOf(const Anchored&) const override { return {}; }
  std::vector<VisiblePoint> VisiblePoints() const override { return {}; }
  std::vector<ScenePoint> Points() const override { return {}; }
  bool SeedMap(std::span<const SeedView>, const SeedProgress&) override { return true; }
  void Finish() override {}
  mutable std::optional<Rigid3> looked_for;
};

TEST(ShutterLag, IsMeasuredFromPosesAndUsedNext) {
  constexpr double kLagS = 0.18;
  const CameraModel camera = CameraModel::Pinhole(120, 80, 100);
  const CoverageMap map(Subject{{0, 0, 0}, 0.2}, {});
  RememberingPoses poses;
  const auto device = OpenDevice("sim:studio?width=32&height=24");
  StillCapture stills(*device, camera, poses, 640);
  double now_s = 0;
  const auto live_until = [&](double to_s) {
    for (; now_s < to_s; now_s += 1 / 15.0) {
      Frame live;
      live.image.pixels = cv::Mat(8, 12, CV_8UC3);
      live.device_time_s = now_s;
      Track track;
      track.cam_from_world = HandAt(now_s);
      stills.Follow(live, track);
    }
  };
  const auto photograph = [&](double requested_s, double told_lag_s) {
    Frame still;
    still.kind = FrameKind::kStill;
    still.image.pixels = cv::Mat(80, 120, CV_8UC3, cv::Scalar(90, 90, 90));
    still.requested_s = requested_s;
    still.device_time_s = requested_s + told_lag_s;
    still.known_cam_from_world = HandAt(requested_s + kLagS);
    const std::uint64_t arrived = stills.counts().arrived;
    const StillVerdict verdict = std::as_const(stills).Judge(still, &map);
    EXPECT_EQ(stills.counts().arrived, arrived) << "judging changes nothing";
    stills.Note(still, verdict);
    EXPECT_EQ(stills.counts().arrived, arrived + 1);
    EXPECT_EQ(stills.counts().recorded + stills.counts().not_needed, arrived + 1);
    // To within half the time between two live frames.
    return std::asin(poses.looked_for->OriginInSource().x()) / 0.3;
  };
  live_until(2.6);
  EXPECT_NEAR(photograph(2, 0), 2, 0.04) << "nothing is known of the lag yet";
  EXPECT_FALSE(stills.counts().lag_s);
  live_until(3.6);
  ASSERT_TRUE(stills.counts().lag_s);
  EXPECT_NEAR(*stills.counts().lag_s, kLagS, 0.004);
  EXPECT_EQ(stills.counts().lags, 1u);
  EXPECT_NEAR(photograph(3, 0), 3 + kLagS, 0.04) << "the measured lag";
  EXPECT_NEAR(photograph(3, 0.4), 3.4, 0.04) << "the device was told one";
  CaptureSummary summary;
  summary.stills = stills.counts();
  EXPECT_THAT(ToText(summary, 1, "vase"), HasSubstr("shutter lag    180 ms (median of 1"));
}

TEST(AsSeenBy, IsTheOtherCamerasPicture) {
  const SimulatedCamera live(Simulated(480, 360)), still(Simulated(1440, 1080));
  const Rigid3 pose = live.hand().CamFromWorld(1);
  Image photograph{still.CleanSrgb(pose), Transfer::kSrgb};
  const Image seen = AsSeenBy(live.camera(), photograph, still.camera());
  const cv::Mat expected = live.CleanSrgb(pose);
  ASSERT_EQ(seen.pixels.size(), expected.size());
  EXPECT_LT(cv::norm(seen.pixels, expected, cv::NORM_L1) / static_cast<double>(3 * expected.total()), 4)
      << "grey levels: the reduced picture is softer at edges";
}
#endif

}  // namespace
}  // namespace ulf::test::still_capture_test
