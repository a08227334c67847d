// Tests: coverage/session/preflight, coverage/session/record/exposure,
// coverage/session/capture_subject,
// coverage/bound/view_decision, coverage/session/record/capture_record.
//
// What a capture watches beside coverage: what is not in order before the first view, an exposure that still
// settles, poses that are corrected, a subject that moves.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/geometry/similarity3.h"
#include "core/geometry/small_matrices.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/capture_session.h"
#include "coverage/session/capture_subject.h"
#include "coverage/session/preflight.h"
#include "coverage/session/record/exposure.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/sources/pose_sources.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test::capture_checks_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const PreflightItem& Item(const std::vector<PreflightItem>& items, const std::string& name) {
  for (const PreflightItem& item : items)
    if (item.name == name) return item;
  throw std::runtime_error("no item " + name);
}

TEST(Preflight, SaysWhatIsNotInOrderAndTheWayOut) {
  const CapturePrediction prediction{
      .disc_radius = 0.02, .nearest = {}, .farthest = {}, .views = ViewsEstimate{500, 450, 560}};
  const PreflightInput good{.source = FrameSource::kSettableCamera,
                            .calibrated = true,
                            .calibration_source = "stored for serial 7",
                            .held = {.exposure = true, .white_balance = true, .focus = {}},
                            .prediction = prediction,
                            .bytes_per_view = 1'000'000,
                            .disk_left_bytes = 600'000'000,
                            .pose_error_px = 0.2};
  for (const PreflightItem& item : Preflight(good)) EXPECT_NE(item.in_order, false) << item.name;
  EXPECT_FALSE(Item(Preflight(good), "focus").in_order) << "cannot be known";
  EXPECT_THAT(Item(Preflight(good), "calibration").words, HasSubstr("serial 7"));

  const auto bad = [&](auto change, const std::string& name, const std::string& way_out) {
    PreflightInput input = good;
    change(input);
    const std::vector<PreflightItem> items = Preflight(input);
    EXPECT_EQ(Item(items, name).in_order, false) << name;
    EXPECT_THAT(Item(items, name).words, HasSubstr(way_out));
    for (const PreflightItem& item : items)
      EXPECT_EQ(item.in_order == false, item.name == name) << item.name << " when it is " << name;
  };
  bad([](PreflightInput& input) { input.has_pose = false, input.pose_error_px.reset(); }, "tracking",
      "not known");
  bad([](PreflightInput& input) { input.calibrated = false; }, "calibration", "ulf calibrate");
  bad([](PreflightInput& input) { input.held.exposure = false; }, "exposure", "ulf features");
  bad([](PreflightInput& input) { input.held.white_balance = false; }, "white balance", "ulf features");
  bad([](PreflightInput& input) { input.held.focus = false; }, "focus", "ulf features");
  bad([](PreflightInput& input) { input.picture.fine_detail = 0.5; }, "focus", "focus on the subject");
  bad([](PreflightInput& input) { input.picture.light = SubjectLight{.brightest_tenth = 0.03}; }, "light",
      "add light");
  bad(
      [](PreflightInput& input) {
        input.picture.light =
            SubjectLight{.clipped_share = 0.5, .brightest_tenth = 0.9, .brightest_hundredth = 0.9};
      },
      "light", "expose less");
  bad([](PreflightInput& input) { input.disk_left_bytes = 400'000'000; }, "disk", "free some space");
  bad([](PreflightInput& input) { input.pose_error_px = 1.2; }, "tracking", "move slowly");
  const acquisition::LinkFact wire{.name = "link", .value = "eth0 to 192.0.2.7: 1000 Mbit/s, MTU 1500"};
  bad(
      [&](PreflightInput& input) {
        input.link = {
            wire,
            {"rate", "at most 45 frames a second, the camera is set to 60", "fps=42 in the URI", false}};
      },
      "rate", "60: fps=42 in the URI");
  PreflightInput linked = good;
  linked.link = {wire};
  EXPECT_THAT(Item(Preflight(linked), "link").words, HasSubstr("1000 Mbit/s"));
  EXPECT_TRUE(HoldsInWords(Preflight(linked)).empty());
  PreflightInput one = good;
  one.prediction.reset();
  one.bytes_per_view = 500'000'000;
  EXPECT_THAT(Item(Preflight(one), "disk").words, HasSubstr("room for at least 1 view"));
  EXPECT_THAT(Item(Preflight(one), "disk").words, ::testing::Not(HasSubstr("1 views")));
  bad([](PreflightInput& input) { input.prediction->views->usual = 150'000, input.bytes_per_view = 10; },
      "views", "smaller cap");
}

// Black things, small ones and those before white are taken with a warning; a cap over the lens, no light and
// an exposure that is far off are not.
TEST(Preflight, LightBlocksOnlyWhereNothingIsVisible) {
  struct Case {
    SubjectLight light;
    std::optional<bool> in_order;
    bool holds;
  };
  for (const bool is_of_subject : {false, true})
    for (const Case& c :
         {Case{{.brightest_tenth = 0.03, .brightest_hundredth = 0.05}, false, true},
          Case{{.brightest_tenth = 0.03, .brightest_hundredth = 0.4}, false, false},
          Case{{.brightest_tenth = 0.3, .brightest_hundredth = 0.4}, true, false},
          Case{{.clipped_share = 0.33, .brightest_tenth = 1, .brightest_hundredth = 1}, false, false},
          Case{{.clipped_share = 0.97, .brightest_tenth = 1, .brightest_hundredth = 1}, false, true}}) {
      PreflightInput input;
      input.picture = {.is_of_subject = is_of_subject, .light = c.light, .fine_detail = {}};
      const PreflightItem light = Item(Preflight(input), "light");
      EXPECT_EQ(light.in_order, c.in_order) << light.words;
      EXPECT_EQ(!HoldsInWords({light}).empty(), c.holds) << light.words;
      if (c.in_order == false) {
        EXPECT_THAT(light.words,
                    HasSubstr(is_of_subject ? "of the subject's circle" : "of the middle of the picture"));
      }
    }
}

TEST(Preflight, AnAutomaticIsAWarning) {
  PreflightInput input;
  input.held = {.exposure = false, .white_balance = false, .focus = false};
  const std::vector<PreflightItem> items = Preflight(input);
  for (const char* name : {"exposure", "white balance", "focus"})
    EXPECT_EQ(Item(items, name).in_order, false);
  EXPECT_EQ(HoldsInWords(items), "");
}

TEST(Preflight, DiskBelowTenViewsBlocksTheStart) {
  PreflightInput input;
  input.bytes_per_view = 1'000'000;
  input.disk_left_bytes = 9'900'000;
  EXPECT_THAT(HoldsInWords(Preflight(input)), AllOf(HasSubstr("9 views"), HasSubstr("free some space")));
  input.disk_left_bytes = 0;
  EXPECT_THAT(HoldsInWords(Preflight(input)), HasSubstr("0 views"));
  input.disk_left_bytes = 10'100'000;
  EXPECT_EQ(HoldsInWords(Preflight(input)), "");
  input.bytes_per_view = 0;
  EXPECT_FALSE(Item(Preflight(input), "disk").in_order) << "how much a view takes is not known";
}

TEST(SubjectFinder, SaysWhatIsWrongAndTheRemedy) {
  const Rigid3 at_origin;
  EXPECT_EQ(ProblemOf({{0, 0, 1}, 0.2}, at_origin, FrameSource::kCamera), "");
  EXPECT_EQ(ProblemOf({{0, 0, -1}, 0.2}, std::nullopt, FrameSource::kCamera), "")
      << "nobody stands anywhere yet";
  const double nan = std::nan("");
  for (const double radius : {0.0, -0.1, nan, HUGE_VAL})
    EXPECT_THAT(ProblemOf({{0, 0, 1}, radius}, at_origin, FrameSource::kCamera),
                HasSubstr("a radius above 0"))
        << radius;
  EXPECT_THAT(ProblemOf({{0, nan, 1}, 0.2}, std::nullopt, FrameSource::kCamera),
              HasSubstr("a centre of numbers"));
  EXPECT_THAT(ProblemOf({{0, 0, 1}, 1.5}, at_origin, FrameSource::kCamera),
              AllOf(HasSubstr("inside that sphere"), HasSubstr("radius 1.5"), HasSubstr("step back")));
  EXPECT_THAT(ProblemOf({{0, 0, 1}, 1}, at_origin, FrameSource::kCamera), HasSubstr("inside"))
      << "on its surface";
  EXPECT_THAT(ProblemOf({{0, 0, -1}, 0.2}, at_origin, FrameSource::kCamera),
              AllOf(HasSubstr("behind the camera"), HasSubstr("turn the camera")));
}

// Brute force: a centre that is off, the rotation that keeps the sphere's centre where it was, and what that
// does to the visible points of the sphere.
TEST(PoseError, IsWhatMovesOnTheSubject) {
  const double focal_px = 600, distance = 2, sigma = 0.001;
  for (const double radius : {0.1, 0.3, 0.6}) {
    double most_px = 0;
    for (const double toward_deg : {0.0, 30.0, 60.0, 90.0}) {  // 0: across the line of sight
      const double toward = toward_deg * M_PI / 180;
      const Eigen::Vector3d off(sigma * std::cos(toward), 0, sigma * std::sin(toward));
      const Eigen::Vector3d center(0, 0, distance);
      const auto turn = TurnBetween(center - off, center);
      for (double polar = 0; polar < std::acos(radius / distance); polar += 0.01) {
        const Eigen::Vector3d point = center + radius * Eigen::Vector3d(std::sin(polar), 0, -std::cos(polar));
        const Eigen::Vector3d seen = turn * (point - off);
        most_px = std::max(most_px, focal_px * (point.hnormalized() - seen.hnormalized()).norm());
      }
    }
    EXPECT_NEAR(PoseErrorPx(sigma, focal_px, distance, radius) / most_px, 1, 0.05) << radius;
  }
}

TEST(Decide, SkipsPosesUncertainByMoreThanAPixel) {
  const CameraModel camera = CameraModel::Pinhole(640, 480, 600);
  const Subject subject{{0, 0, 1}, 0.15};
  const CoverageMap map(subject, CoverageMapOptions{.cap = {}, .threshold_px = 7});
  Frame frame;
  frame.image.pixels = cv::Mat(480, 640, CV_8UC3, cv::Scalar(120, 120, 120));
  Track track;
  track.state = TrackState::kTracking;
  track.cam_from_world = Rigid3{};
  track.sharpness = 1;
  const auto reason = [&](int coverage_width_px) {
    return Decide({.frame = frame, .track = track, .camera = camera, .coverage_width_px = coverage_width_px},
                  &map)
        .reason;
  };
  EXPECT_EQ(reason(640), Reason::kRecorded) << "a pose that is given, without a word about its error";
  const double at_the_limit = 0.85 / (600 * 0.15);
  track.center_sigma = 0.98 * at_the_limit;
  EXPECT_EQ(reason(640), Reason::kRecorded);
  track.center_sigma = 1.02 * at_the_limit;
  EXPECT_EQ(reason(640), Reason::kTracking);
  EXPECT_EQ(reason(320), Reason::kRecorded) << "of the coverage image, never of the sensor";
  track.center_sigma = 0.1 * at_the_limit;
  track.rows_sigma = 1.02 * at_the_limit;
  EXPECT_EQ(reason(640), Reason::kTracking) << "rows that one pose cannot be right for";
  track.rows_sigma = 0;
  track.lens_error_share = 0.1;
  track.quality = 0.01;
  EXPECT_EQ(reason(640), Reason::kRecorded) << "a wrong lens is found after the capture";

  const auto without_subject = [&] {
    return DecideWithoutSubject({.frame = frame, .track = track, .camera = camera, .coverage_width_px = 640},
                                false)
        .reason;
  };
  track.distance = 2;
  track.center_sigma = 0.019;
  EXPECT_EQ(without_subject(), Reason::kRecorded);
  track.center_sigma = 0.021;
  EXPECT_EQ(without_subject(), Reason::kTracking);
  track.center_sigma = 0.001;
  track.rows_sigma = 0.021;
  EXPECT_EQ(without_subject(), Reason::kTracking);
}

TEST(Preflight, IsShownAndSaidOnceInACapture) {
  for (const bool calibrated : {true, false}) {
    const ScratchFolder scratch;
    CaptureOptions options = Options();
    options.cap = Cap::ParseDegrees("20x10");
    options.calibrated = calibrated;
    std::vector<std::string> said;
    SharedCaptureState last;
    CaptureHooks hooks;
    hooks.say = [&](const std::string& line) { said.push_back(line); };
    hooks.after_frame = [&](const SharedCaptureState& now) { last = now; };
    Capture(scratch / "lf", Sweep(6, 4, 1), options, {}, hooks);
    std::size_t times = 0;
    for (const std::string& line : said) times += line.find("before the first view: calibration") == 0;
    EXPECT_EQ(times, calibrated ? 0u : 1u);
    EXPECT_EQ(Item(last->preflight, "calibration").in_order, calibrated);
    EXPECT_EQ(Item(last->preflight, "disk").in_order, true);
    EXPECT_FALSE(last->exposure_locked) << "a plane tells nothing of its exposure";
    ASSERT_TRUE(last->prediction);
    EXPECT_GT(last->prediction->views->usual, 10);
  }
}

// A camera whose exposure comes to rest: told by its settings, or seen in the picture alone. `held`: what it
// says of its automatic.
class SettlingDevice : public PlanarDevice {
 public:
  SettlingDevice(std::vector<PlanarShot> shots, bool tells, std::optional<bool> held)
      : PlanarDevice(std::move(shots)), tells_(tells), held_(held) {}
  HeldAutomatics Held() const override { return {.exposure = held_, .white_balance = {}, .focus = {}}; }
  std::optional<Frame> Next(std::chrono::milliseconds timeout) override {
    auto frame = PlanarDevice::Next(timeout);
    if (!frame) return frame;
    const double light = std::max(0.5, 1 - 0.06 * taken_++);  // at rest from the tenth frame on
    frame->exposure_s = tells_ ? 0.001 * light : 0;
    if (!tells_) {
      cv::Mat darker;
      frame->image.pixels.convertTo(darker, -1, light);
      frame->image.pixels = darker;
    }
    return frame;
  }

 private:
  bool tells_;
  std::optional<bool> held_;
  int taken_ = 0;
};

TEST(ExposureUnsettled, IsAReasonOfItsOwnUntilItRests) {
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 25; ++i) shots.push_back({PoseAt(1.8 * i - 20, 0)});  // each uncovered
  for (const auto& [tells, held] : {std::pair{true, true}, {true, false}, {false, true}}) {
    const ScratchFolder scratch;
    SettlingDevice device(shots, tells, held);
    const auto poses = MakeKnownPoseSource(kCamera, kSubject);
    device.Start();
    const CaptureSummary summary = RunCapture(device, kCamera, *poses, NewWriter(scratch / "lf"), Options());
    const Counts counted = Counted(summary);
    EXPECT_GE(counted.at("unsettled"), 8u) << tells;
    EXPECT_LE(counted.at("unsettled"), 13u) << "0.3 s after it has come to rest it is settled";
    EXPECT_EQ(counted.at("unsettled") + counted.at("recorded"), 25u) << tells;
  }
  const ScratchFolder scratch;
  EXPECT_EQ(Counted(Capture(scratch / "lf", shots).summary), (Counts{{"recorded", 25}}))
      << "moving is no change of exposure";
}

// A video, a recording, a webcam that exposes by itself and does not tell: waiting would be for nothing.
TEST(ExposureUnsettled, IsNoReasonWhenLightIsMatched) {
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 25; ++i) shots.push_back({PoseAt(1.8 * i - 20, 0)});
  for (const auto& [tells, held] :
       {std::pair<bool, std::optional<bool>>{false, {}}, {true, {}}, {false, false}}) {
    const ScratchFolder scratch;
    SettlingDevice device(shots, tells, held);
    const auto poses = MakeKnownPoseSource(kCamera, kSubject);
    device.Start();
    const CaptureSummary summary = RunCapture(device, kCamera, *poses, NewWriter(scratch / "lf"), Options());
    EXPECT_EQ(Counted(summary), (Counts{{"recorded", 25}})) << tells;
    const LightField light_field = ReadLightField(scratch / "lf");
    ASSERT_EQ(light_field.views.size(), 25u);
    for (std::size_t i = 0; i < 25; ++i) {
      const double light = std::max(0.5, 1 - 0.06 * static_cast<double>(i));
      const View& view = light_field.views[i];
      if (tells) {
        EXPECT_NEAR(view.exposure_s, 0.001 * light, 1e-9);
        EXPECT_EQ(view.gain, 1) << "told is not guessed";
      } else {
        // The device scales what is stored, which is display-encoded: LinearFromSrgb goes with about 2.2.
        EXPECT_NEAR(view.gain, std::pow(light, 2.2), 0.2 * std::pow(light, 2.2)) << i;
      }
    }
  }
}

// As much light in each: no gain that wanders along the way.
TEST(ExposureMatch, LeavesASteadyLightAsItIs) {
  std::vector<PlanarShot> shots;
  for (int row = 0; row < 4; ++row)
    for (int i = 0; i < 20; ++i)
      shots.push_back({PoseAt((row % 2 ? 20 - 2.0 * i : 2.0 * i - 20), 2.5 * row)});
  const ScratchFolder scratch;
  const LightField light_field = Capture(scratch / "lf", shots).light_field;
  ASSERT_GT(light_field.views.size(), 60u);
  for (const View& view : light_field.views) EXPECT_NEAR(view.gain, 1, 0.05) << view.id;
}

TEST(ExposureMatch, GoesOnWithTheLightOfTheResumedViews) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 16; ++i) shots.push_back({PoseAt(1.8 * i - 14, 0)});
  const auto half = shots.begin() + 8;
  for (const bool second : {false, true}) {
    SettlingDevice device(second ? std::vector(half, shots.end()) : std::vector(shots.begin(), half), false,
                          {});
    const auto poses = MakeKnownPoseSource(kCamera, kSubject);
    device.Start();
    RunCapture(device, kCamera, *poses,
               second ? LightFieldWriter::Resume(scratch / "lf") : NewWriter(scratch / "lf"), Options());
  }
  const LightField light_field = ReadLightField(scratch / "lf");
  ASSERT_EQ(light_field.views.size(), 16u);
  // The camera began anew with full light, in the second session as in the first.
  EXPECT_NEAR(light_field.views[8].gain, 1, 0.1);
  EXPECT_LT(light_field.views[7].gain, 0.4);
}

// A loop that is closed, or a map that becomes metric: every view stands elsewhere, in other units.
TEST(ExposureMatch, FindsNeighboursThatWereMoved) {
  constexpr double kScale = 4, kLight = 0.6;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.5, Vector3d(0.2, 1, 0.1).normalized()));
  const auto corrected = [&](const Rigid3& cam_from_world) {
    const Eigen::Quaterniond rotation = cam_from_world.rotation * turn.conjugate();
    return Rigid3{rotation, kScale * cam_from_world.translation - rotation * Vector3d(30, -5, 12)};
  };
  PlanarDevice device({{PoseAt(-3, 0)}, {PoseAt(3, 0)}, {PoseAt(0, 0)}});
  device.Start();
  ExposureMatch match{LightField{}};
  RecordedViews views{LightField{}};
  const auto next = [&] { return *device.Next(std::chrono::milliseconds(0)); };
  std::map<int, Rigid3> moved;
  for (int id = 1; id <= 2; ++id) {
    const Frame frame = next();
    EXPECT_NEAR(match.GainOf(frame.image, kCamera, *frame.known_cam_from_world, 1, views), 1, 0.05);
    match.Keep(id);
    views.Add({id, {}, *frame.known_cam_from_world});
    moved[id] = corrected(*frame.known_cam_from_world);
  }
  views.SetPoses(moved);
  const Frame frame = next();
  Image darker{.pixels = {}, .transfer = frame.image.transfer};
  frame.image.pixels.convertTo(darker.pixels, -1, kLight);
  const double expected = std::pow(kLight, 2.2);
  EXPECT_NEAR(match.GainOf(darker, kCamera, corrected(*frame.known_cam_from_world), kScale, views), expected,
              0.2 * expected);
}

// Half of the map moves towards the subject: the sphere cannot follow both halves.
class HalfDriftingSource : public DriftingSource {
 public:
  HalfDriftingSource() : DriftingSource(Rigid3{Eigen::Quaterniond::Identity(), {0, 0, -0.2}}) {}
  Track Step(const Frame& frame) override {
    Track track = DriftingSource::Step(frame);
    if (track.cam_from_world->OriginInSource().x() > 0) track.anchor->keyframe_id = kMoving;
    return track;
  }
  Rigid3 PoseOf(const Anchored& anchor) const override {
    return anchor.keyframe_id == kMoving ? DriftingSource::PoseOf(anchor) : anchor.cam_from_keyframe;
  }

 private:
  static constexpr int kMoving = 4;
};

TEST(CorrectedPoses, ReopenedDirectionsAreShownAndSaid) {
  const ScratchFolder scratch;
  HalfDriftingSource poses;
  PlanarDevice device(Sweep(10, 4, 0.8));
  device.Start();
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("12x6");
  std::vector<std::string> said;
  SharedCaptureState last;
  CaptureHooks hooks;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  double covered_before = 0;
  std::size_t reopened_before = 1, reopened_after = 0;
  double covered_after = 0;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (now->frames == 35) {
      covered_before = *now->covered;
      reopened_before = now->reopened.size();
      poses.Adjust(true);
    }
    if (now->frames == 36) covered_after = *now->covered, reopened_after = now->reopened.size();
  };
  RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), options, hooks);
  EXPECT_LT(covered_after, covered_before - 0.005) << "nothing fell open: the test shows nothing";
  EXPECT_EQ(reopened_before, 0u);
  EXPECT_GT(reopened_after, 0u);
  EXPECT_THAT(
      said,
      Contains(::testing::MatchesRegex("poses were corrected: [0-9.]+ % of the cap must be taken again")));
}

// A tracker that looks for points on the subject and off it.
class WatchedSource : public DriftingSource {
 public:
  WatchedSource() : DriftingSource(Rigid3{}) {}
  std::vector<ExpectedPoint> ExpectedPoints() const override {
    std::vector<ExpectedPoint> points;
    for (int i = 0; i < 40; ++i) points.push_back({{0.002 * i, 0, 0}, 0.8, 30, !subject_gone && i % 5 > 0});
    for (int i = 0; i < 100; ++i) points.push_back({{1 + 0.01 * i, 0, 0}, 0.8, 30, i % 5 > 0});
    return points;
  }
  bool subject_gone = false;
};

TEST(SubjectMoved, IsSaidOnceAndShown) {
  const ScratchFolder scratch;
  WatchedSource poses;
  PlanarDevice device(Sweep(10, 4, 0.8));
  device.Start();
  std::vector<std::string> said;
  std::vector<bool> shown;
  CaptureRequests requests;
  CaptureHooks hooks;
  hooks.requests = &requests;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  hooks.after_frame = [&](const SharedCaptureState& now) {
    poses.subject_gone = now->frames >= 20 && now->frames < 50;
    if (now->frames == 60) requests.Push(PlaceSphere{kSubject});
    shown.push_back(now->subject_moved);
  };
  RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), Options(), hooks);
  ASSERT_GT(shown.size(), 70u);
  EXPECT_FALSE(shown[19]);
  EXPECT_TRUE(shown[20 + 15]) << "after a second";
  EXPECT_TRUE(shown[50 + 9]) << "new points on it say nothing of the old views";
  EXPECT_FALSE(shown[60 + 5]) << "placed anew";
  std::size_t times = 0;
  for (const std::string& line : said) times += line.find("seems to have moved") != std::string::npos;
  EXPECT_EQ(times, 1u);
}

// The real tracker before a wall with a box, which is pushed aside while the camera sways on: noticed within
// one and a half seconds, and nothing before.
TEST(SubjectMoved, IsNoticedOnlyByTheTrackersPoints) {
  constexpr int kPlaced = 50, kPushed = 130, kFrames = kPushed + 45;
  for (const unsigned seed : SeedsOf({1, 2})) {
    const TexturedRoom room({.furniture = Furniture::kBox, .seed = seed});
    Tracker tracker(TexturedRoom::Camera(), {.deterministic = true, .seed = seed});
    SubjectWatch watch;
    std::optional<Subject> box;
    std::vector<Eigen::Vector3d> centers, true_centers;
    int noticed = -1;
    for (int i = 0; i < kFrames && noticed < 0; ++i) {
      const Rigid3 truth = TexturedRoom::HandAt(i);
      const TexturedRoom::Moment moment{.furniture_shift = {i >= kPushed ? 0.05 : 0, 0, 0}};
      const Track track =
          tracker.Step(room.Take(truth, static_cast<std::uint64_t>(i), TexturedRoom::Camera(), moment));
      if (!track.cam_from_world) continue;
      if (i < kPlaced) {
        centers.push_back(track.cam_from_world->OriginInSource());
        true_centers.push_back(truth.OriginInSource());
        continue;
      }
      if (!box) {
        ASSERT_GT(centers.size(), 20u) << "seed " << seed;
        const auto tracked_from_true = AlignPoints(true_centers, centers);
        ASSERT_TRUE(tracked_from_true) << "seed " << seed;
        box = Subject{*tracked_from_true * Eigen::Vector3d(0.18, 0.2, 2.6), 0.42 * tracked_from_true->scale};
      }
      if (watch.Moved(i / 30.0, tracker.ExpectedPoints(), *box)) noticed = i;
    }
    EXPECT_GE(noticed, kPushed) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ulf::test::capture_checks_test
