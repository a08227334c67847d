// Tests: coverage/session/capture_answers, coverage/session/capture_state, coverage/session/preflight,
// coverage/session/record/capture_record, coverage/session/capture_subject.
//
// What is asked of a running capture, and what whoever looks at it sees.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/bound/criterion.h"
#include "coverage/session/capture_session.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::capture_requests_test {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// One new viewpoint a frame, so that view N is frame N's.
std::vector<PlanarShot> Steps(int count, double from_deg = 0) {
  std::vector<PlanarShot> shots;
  for (int i = 0; i < count; ++i) shots.push_back({PoseAt(from_deg + 3.0 * i, 0)});
  return shots;
}

std::size_t FilesIn(const fs::path& folder) {
  return fs::exists(folder) ? static_cast<std::size_t>(
                                  std::distance(fs::directory_iterator(folder), fs::directory_iterator{}))
                            : 0;
}

std::vector<int> Ids(const LightField& light_field) {
  std::vector<int> ids;
  for (const View& view : light_field.views) ids.push_back(view.id);
  return ids;
}

// A capture that is asked something after some frames, and everything it says and shows.
struct Asked {
  CaptureRequests requests;
  std::map<std::uint64_t, CaptureRequest> after;  // frames
  std::vector<SharedCaptureState> states;
  std::vector<std::string> said;

  CaptureHooks Hooks() {
    CaptureHooks hooks;
    hooks.requests = &requests;
    hooks.say = [this](const std::string& line) { said.push_back(line); };
    hooks.after_frame = [this](const SharedCaptureState& now) {
      states.push_back(now);
      if (const auto found = after.find(now->frames); found != after.end()) requests.Push(found->second);
    };
    return hooks;
  }
};

CaptureOptions Threaded(bool threaded) {
  CaptureOptions options = Options();
  options.deterministic = !threaded;
  return options;
}

TEST(CaptureRequests, TakenBackViewsReopenTheirPlaces) {
  for (const bool threaded : {false, true}) {
    const ScratchFolder scratch;
    Asked asked;
    asked.after[4] = TakeBackLast{2};
    asked.after[5] = TakeBackViews{{2, 77}};
    std::vector<PlanarShot> shots = Steps(5);
    shots.push_back({PoseAt(9, 0)});  // where view 4 was
    const Captured captured = Capture(scratch / "lf", shots, Threaded(threaded), {}, asked.Hooks());
    EXPECT_THAT(Ids(captured.light_field), ElementsAre(1, 5, 6)) << "no number is given twice";
    EXPECT_EQ(captured.summary.recorded, 3u);
    EXPECT_EQ(captured.summary.taken_back, 3u);
    EXPECT_EQ(FilesIn(scratch / "lf/images"), 3u);
    EXPECT_EQ(FilesIn(scratch / "lf/unposed"), 3u) << "no photograph is lost";
    EXPECT_TRUE(fs::exists(scratch / "lf/unposed/000003.png"));
    for (const View& view : captured.light_field.views) {
      const double azimuth_deg = view.id == 1 ? 0 : view.id == 5 ? 12 : 9;
      EXPECT_LT((view.CenterInWorld() - PoseAt(azimuth_deg, 0).OriginInSource()).norm(), 1e-9) << view.id;
      PlanarDevice again({{PoseAt(azimuth_deg, 0)}});
      again.Start();
      const cv::Mat expected = again.Next(std::chrono::milliseconds(0))->image.pixels;
      EXPECT_EQ(cv::norm(ReadViewImage(captured.light_field, view).pixels, expected, cv::NORM_INF), 0)
          << view.id;
    }
    EXPECT_THAT(asked.said, Contains(AllOf(HasSubstr("2 views (3, 4)"), HasSubstr(" must be taken again"))));
    EXPECT_THAT(asked.said, Contains(HasSubstr("there is no view 77")));

    ASSERT_EQ(asked.states.size(), 6u);
    EXPECT_THAT(asked.states[3]->view_ids, ElementsAre(1, 2, 3, 4));
    EXPECT_THAT(asked.states[4]->view_ids, ElementsAre(1, 2, 5));
    EXPECT_THAT(asked.states[5]->view_ids, ElementsAre(1, 5, 6));
    const Vector3d taken = PoseAt(6, 0).OriginInSource().normalized();
    EXPECT_EQ(asked.states[3]->coverage->At(taken)->index, 2);
    EXPECT_EQ(asked.states[4]->coverage->At(taken)->index, -1);
    const auto is_open = [](const CaptureState& state, const Vector3d& direction) {
      for (const Vector3d& open : state.reopened)
        if (open.dot(direction) > std::cos(Radians(0.5))) return true;
      return false;
    };
    EXPECT_FALSE(is_open(*asked.states[3], taken));
    EXPECT_TRUE(is_open(*asked.states[4], taken));
    const Vector3d again = PoseAt(9, 0).OriginInSource().normalized();
    EXPECT_TRUE(is_open(*asked.states[4], again));
    EXPECT_FALSE(is_open(*asked.states[5], again)) << "recorded once more";
  }
}

TEST(CaptureRequests, LoseNothingThatWaitsInTheSpool) {
  const ScratchFolder scratch;
  PlanarDeviceOptions device;
  device.camera = CameraModel::Pinhole(1600, 1200, 1500);  // slow to encode
  CaptureOptions options = Threaded(true);
  options.spool_views = 64;
  Asked asked;
  for (const std::uint64_t frame : {3, 4, 7, 12}) asked.after[frame] = TakeBackLast{1};
  const Captured captured = Capture(scratch / "lf", Steps(12), options, device, asked.Hooks());
  EXPECT_THAT(Ids(captured.light_field), ElementsAre(1, 2, 5, 6, 8, 9, 10, 11));
  EXPECT_EQ(FilesIn(scratch / "lf/images"), 8u);
  EXPECT_EQ(FilesIn(scratch / "lf/unposed"), 4u);
  for (const View& view : captured.light_field.views)
    EXPECT_LT((view.CenterInWorld() - PoseAt(3.0 * (view.id - 1), 0).OriginInSource()).norm(), 1e-9)
        << view.id;
}

TEST(CaptureRequests, AllViewsMayBeTakenBack) {
  const ScratchFolder scratch;
  Asked asked;
  asked.after[3] = TakeBackLast{3};
  asked.after[4] = TakeBackLast{1};
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("20x10");
  std::vector<PlanarShot> shots = Steps(3);
  shots.push_back({PoseAt(0, 0), Fault::kNoPose});
  shots.push_back({PoseAt(0, 0), Fault::kNoPose});
  const Captured captured = Capture(scratch / "lf", shots, options, {}, asked.Hooks());
  EXPECT_TRUE(captured.light_field.views.empty());
  EXPECT_EQ(captured.summary.recorded, 0u);
  EXPECT_GT(*asked.states[2]->covered, 0);
  EXPECT_EQ(*asked.states[3]->covered, 0);
  EXPECT_THAT(asked.said, Contains("there is no view to take back"));
}

TEST(CaptureRequests, TakeBackOnlyExistingViews) {
  const ScratchFolder scratch;
  Asked asked;
  asked.after[3] = TakeBackLast{1000};
  const Captured captured = Capture(scratch / "lf", Steps(5), Options(), {}, asked.Hooks());
  EXPECT_EQ(captured.light_field.views.size(), 5u);
  EXPECT_EQ(captured.light_field.taken_back.size(), 0u);
  EXPECT_THAT(asked.said, Contains(AllOf(HasSubstr("1000 views asked for"), HasSubstr("there are 3"))));
}

// Two answers to what was asked between two frames: the second hides the first from nobody.
TEST(CaptureRequests, EveryAnswerStandsInTheNextState) {
  const ScratchFolder scratch;
  Asked asked;
  CaptureHooks hooks = asked.Hooks();
  hooks.after_frame = [&](const SharedCaptureState& now) {
    asked.states.push_back(now);
    if (now->frames != 3) return;
    asked.requests.Push(TakeBackViews{{77}});
    asked.requests.Push(TakeBackViews{{78}});
  };
  Capture(scratch / "lf", Steps(5), Options(), {}, hooks);
  EXPECT_EQ(asked.states[3]->times_said, asked.states[2]->times_said + 2);
  EXPECT_THAT(asked.states[3]->said, AllOf(Contains(HasSubstr("view 77")), Contains(HasSubstr("view 78"))));
}

TEST(CaptureRequests, ResumeAfterATakeBackIsRight) {
  const ScratchFolder scratch;
  Asked first, second;
  first.after[4] = TakeBackViews{{2}};
  Capture(scratch / "lf", Steps(5), Options(), {}, first.Hooks());
  second.after[2] = TakeBackViews{{1}};  // of the earlier session
  const Captured captured = Capture(scratch / "lf", Steps(3, 20), Options(), {}, second.Hooks());
  EXPECT_THAT(Ids(captured.light_field), ElementsAre(3, 4, 5, 6, 7, 8));
  EXPECT_EQ(captured.summary.recorded, 3u);
  EXPECT_EQ(captured.summary.taken_back, 1u);
  EXPECT_EQ(captured.light_field.taken_back.size(), 2u) << "of both sessions";
  EXPECT_EQ(FilesIn(scratch / "lf/unposed"), 2u);
  EXPECT_THAT(second.states.back()->view_ids, ElementsAre(3, 4, 5, 6, 7, 8));
}

// Corrections are by view, not by place in a list.
TEST(CaptureRequests, PosesReachViewsAfterATakeBack) {
  const Rigid3 late_from_live{Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Vector3d::UnitZ())), {0.01, 0, 0}};
  for (const bool at_the_end : {false, true}) {
    const ScratchFolder scratch;
    DriftingSource poses(late_from_live);
    PlanarDevice device(Steps(12));
    device.Start();
    Asked asked;
    asked.after[6] = TakeBackViews{{2, 5}};
    CaptureHooks hooks = asked.Hooks();
    const auto look = hooks.after_frame;
    hooks.after_frame = [&](const SharedCaptureState& now) {
      look(now);
      if (!at_the_end && now->frames == 8) poses.Adjust(true);
    };
    RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), Options(), hooks);
    const LightField light_field = ReadLightField(scratch / "lf");
    EXPECT_THAT(Ids(light_field), ElementsAre(1, 3, 4, 6, 7, 8, 9, 10, 11, 12));
    for (const View& view : light_field.views)
      EXPECT_LT(
          (late_from_live.Inverse() * view.CenterInWorld() - PoseAt(3.0 * (view.id - 1), 0).OriginInSource())
              .norm(),
          1e-9)
          << view.id;
  }
}

TEST(CaptureRequests, NewSubjectRepaintsAllViews) {
  const ScratchFolder scratch;
  const Subject other{{0.02, 0, 0}, 0.12};
  Asked asked;
  asked.after[4] = PlaceSphere{other};
  asked.after[5] = PlaceSphere{{{0, 0, 3}, 0.1}};  // behind the camera
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("60x40");
  const Captured captured = Capture(scratch / "lf", Steps(6), options, {}, asked.Hooks());
  EXPECT_EQ(captured.light_field.subject, other);
  EXPECT_EQ(captured.summary.subject, other);
  EXPECT_THAT(asked.said, Contains(AllOf(HasSubstr("stays as it was"), HasSubstr("behind the camera"))));
  const auto share_painted_for = [&](const Subject& subject, std::size_t views = 6) {
    auto recorded = CriterionViews(captured.light_field);
    recorded.resize(views);
    return CoverageMap(subject, {.cap = options.cap, .threshold_px = options.threshold_px}, recorded)
        .CoveredShare();
  };
  EXPECT_THAT(asked.said,
              Contains(AllOf(HasSubstr("the subject is at"),
                             HasSubstr(fmt::format(
                                 "4 views painted anew: {:.1f} % covered, before it was {:.1f} %",
                                 100 * share_painted_for(other, 4), 100 * share_painted_for(kSubject, 4))))));
  const double shown = asked.states.back()->coverage->CoveredShare();
  EXPECT_NEAR(shown / share_painted_for(other), 1, 0.02);
  EXPECT_GT(std::abs(shown / share_painted_for(kSubject) - 1), 0.1) << "the test shows nothing";
  EXPECT_EQ(captured.light_field.views.size(), 6u);
}

TEST(CaptureRequests, FindANewSubjectInThePicture) {
  const ScratchFolder scratch;
  DriftingSource poses(Rigid3{});
  std::vector<PlanarShot> shots = Steps(4);
  shots.push_back({Turned(PoseAt(9, 0), 8)});
  shots.push_back({Turned(PoseAt(9, 0), 8)});
  PlanarDevice device(shots);
  device.Start();
  Asked asked;
  asked.after[5] = FindSubject{{}, 0.2};
  asked.after[6] = FindSubject{0.5, {}};
  const CaptureSummary summary =
      RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), Options(), asked.Hooks());
  ASSERT_EQ(asked.states.size(), 6u);
  EXPECT_EQ(asked.states[4]->subject, kSubject);
  const Subject found = *asked.states[5]->subject;
  EXPECT_NEAR(found.center_in_world.z(), 0, 0.02) << "on the plane";
  const Vector3d in_cam = shots[4].cam_from_world * found.center_in_world;
  EXPECT_LT(in_cam.head<2>().norm(), 1e-9) << "on the axis";
  EXPECT_NEAR((shots[4].cam_from_world * summary.subject->center_in_world).z(), 0.5, 1e-9)
      << "as deep as asked";
}

TEST(CaptureRequests, APauseIsCountedAndWrittenDown) {
  const ScratchFolder scratch;
  Asked asked;
  asked.after[3] = SetRecording{false};
  asked.after[9] = SetRecording{true};
  const Captured captured = Capture(scratch / "lf", Steps(12), Options(), {}, asked.Hooks());
  EXPECT_EQ(Counted(captured.summary), (Counts{{"recorded", 6}, {"paused", 6}}));
  EXPECT_TRUE(asked.states[2]->recording);
  EXPECT_FALSE(asked.states[3]->recording);
  EXPECT_TRUE(asked.states[9]->recording);
  EXPECT_THAT(ReadWholeFile(scratch / "lf/journal.jsonl"), HasSubstr("recording paused: as asked"));
}

TEST(CaptureRequests, FinishClosesTheLightField) {
  const ScratchFolder scratch;
  Asked asked;
  asked.after[3] = FinishCapture{};
  const Captured captured = Capture(scratch / "lf", Steps(12), Options(), {}, asked.Hooks());
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kClosed);
  EXPECT_STREQ(Name(captured.summary.stopped_because), "closed");
  EXPECT_EQ(captured.summary.frames, 3u);
  EXPECT_TRUE(fs::exists(scratch / "lf/transforms.json"));
}

TEST(CaptureStateTest, LastOneSaysWhyTheCaptureEnds) {
  const ScratchFolder scratch;
  Asked asked;
  CaptureHooks hooks = asked.Hooks();
  std::vector<SharedCaptureState> last;
  bool closed_by_then = false;
  hooks.while_waiting = [&](const SharedCaptureState& now) {
    if (!now->ended) return;
    last.push_back(now);
    closed_by_then = fs::exists(scratch / "lf/transforms.json");
  };
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("6x4");
  const Captured captured = Capture(scratch / "lf", Sweep(9, 7, 0.55), options, {}, hooks);
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kCovered);
  ASSERT_EQ(last.size(), 1u);
  EXPECT_EQ(last[0]->ended, StoppedBecause::kCovered);
  EXPECT_FALSE(closed_by_then);
  for (const SharedCaptureState& state : asked.states) EXPECT_FALSE(state->ended);
}

TEST(CaptureStateTest, DirectionsFollowHowCameraIsHeld) {
  CaptureState state;
  state.subject = Subject{{0, 0, 0}, 0.2};
  state.cam_from_world = LookAt({0, 0, -2}, {0, 0, 0}, {0, -1, 0});
  EXPECT_EQ(WayInWords(state), "");
  const auto toward = [](double right_deg, double up_deg) {
    const double right = right_deg * M_PI / 180, up = up_deg * M_PI / 180;
    return Eigen::Vector3d{std::sin(right) * std::cos(up), -std::sin(up), -std::cos(right) * std::cos(up)};
  };
  state.guidance.toward = toward(10, 0);
  EXPECT_EQ(WayInWords(state), "10° right");
  state.guidance.toward = toward(0, 7);
  state.guidance.distance = 1.8;
  EXPECT_EQ(WayInWords(state), "7° up, 10 % nearer");
  state.metric = true;
  EXPECT_EQ(WayInWords(state), "7° up, 20 cm nearer");
  state.guidance.distance = 2.004;
  EXPECT_EQ(WayInWords(state), "7° up") << "too little to walk";
  state.metric = false;
  // Held upside down.
  state.cam_from_world = LookAt({0, 0, -2}, {0, 0, 0}, {0, 1, 0});
  state.guidance.distance = 2.5;
  EXPECT_EQ(WayInWords(state), "7° down, 25 % back");
  state.guidance = {};
  state.guidance.toward = toward(-120, 0);
  EXPECT_EQ(WayInWords(state), "120° right") << "round the subject";
  state.guidance.toward = toward(0.3, 0.3);
  EXPECT_EQ(WayInWords(state), "");
}

// The camera stands: to see more of the right side the table turns clockwise.
TEST(CaptureStateTest, DirectionsAreTheTurntables) {
  CaptureState state;
  state.subject = Subject{{0, 0, 0}, 0.2};
  state.table_up_in_world = -Eigen::Vector3d::UnitY();
  const auto from = [](double azimuth_deg, double elevation_deg) {
    const double azimuth = azimuth_deg * M_PI / 180, elevation = elevation_deg * M_PI / 180;
    return Eigen::Vector3d{std::sin(azimuth) * std::cos(elevation), -std::sin(elevation),
                           -std::cos(azimuth) * std::cos(elevation)};
  };
  state.cam_from_world = LookAt(2 * from(0, 30), {0, 0, 0}, {0, -1, 0});
  state.guidance.toward = from(50, 30);
  EXPECT_EQ(WayInWords(state), "turn the table 50° clockwise") << "although a great circle leads upwards";
  state.guidance.toward = from(-50, 42);
  state.guidance.distance = 1.8;
  EXPECT_EQ(WayInWords(state),
            "turn the table 50° counterclockwise, the camera 12° up, the camera 10 % nearer");
  state.guidance.distance = 0;
  state.guidance.toward = from(0, 25);
  EXPECT_EQ(WayInWords(state), "the camera 5° down");
}

TEST(CaptureStateTest, CountsAnsweredRequests) {
  const ScratchFolder scratch;
  Asked asked;
  asked.after[2] = TakeBackViews{{77}};  // there is none: answered all the same
  asked.after[4] = SetRecording{false};
  Capture(scratch / "lf", Steps(6), Options(), {}, asked.Hooks());
  std::vector<std::uint64_t> answered;
  for (const SharedCaptureState& state : asked.states) answered.push_back(state->requests_answered);
  EXPECT_THAT(answered, ElementsAre(0, 0, 1, 1, 2, 2));
}

TEST(CaptureStateTest, PublishedStatesNeverChange) {
  const ScratchFolder scratch;
  Asked asked;
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("40x20");
  asked.after[6] = TakeBackLast{3};
  const std::vector<PlanarShot> shots = Steps(8);
  std::vector<double> covered;
  CaptureHooks hooks = asked.Hooks();
  const auto look = hooks.after_frame;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    look(now);
    covered.push_back(now->coverage->CoveredShare());
  };
  Capture(scratch / "lf", shots, options, {}, hooks);
  for (std::size_t i = 0; i < asked.states.size(); ++i) {
    const CaptureState& state = *asked.states[i];
    EXPECT_EQ(state.coverage->CoveredShare(), covered[i]) << i;
    EXPECT_EQ(*state.covered, covered[i]) << i;
    EXPECT_EQ(state.view_ids.size(), state.coverage->views().size()) << i;
    EXPECT_EQ(state.recorded_view, static_cast<int>(i) + 1);
    EXPECT_EQ(state.decision.reason, Reason::kRecorded);
    PlanarDevice again({shots[i]});
    again.Start();
    EXPECT_EQ(
        cv::norm(state.live.pixels, again.Next(std::chrono::milliseconds(0))->image.pixels, cv::NORM_INF), 0);
  }
  EXPECT_NEAR(*asked.states.back()->frames_per_s, 15, 1e-6);
  EXPECT_GT(*asked.states.back()->disk_left_bytes, 0u);
}

// Also where nobody looks any more: a map that was given out is nobody's to change.
TEST(CaptureStateTest, ANewViewMakesANewMap) {
  const ScratchFolder scratch;
  std::weak_ptr<const CoverageMap> before;
  std::size_t replaced = 0;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    replaced += now->coverage->views().size() > 1 && before.expired();
    before = now->coverage;
  };
  Capture(scratch / "lf", Steps(6), Options(), {}, hooks);
  EXPECT_EQ(replaced, 5u);
}

TEST(CaptureStateTest, ViewIsNewInOneStateOnly) {
  const ScratchFolder scratch;
  Asked asked;
  CaptureHooks hooks = asked.Hooks();
  hooks.while_waiting = hooks.after_frame;  // the device has ended; the capture has
  Capture(scratch / "lf", Steps(5), Options(), {}, hooks);
  std::vector<int> recorded;
  ASSERT_EQ(asked.states.size(), 7u);
  for (std::size_t i = 0; i < asked.states.size(); ++i) {
    const CaptureState& state = *asked.states[i];
    if (state.recorded_view) recorded.push_back(*state.recorded_view);
    ASSERT_TRUE(state.newest_view);
    EXPECT_EQ(state.newest_view->id, state.view_ids.back());
    EXPECT_EQ(state.newest_view->frame.image.pixels.data, state.live.pixels.data) << "shared, not copied";
    EXPECT_EQ(state.light_field, scratch / "lf");
  }
  EXPECT_THAT(recorded, ElementsAre(1, 2, 3, 4, 5));
}

TEST(CaptureStateTest, ExpectsViewsByEstimateThenByGaps) {
  const ScratchFolder scratch;
  Asked asked;
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("20x10");
  Capture(scratch / "lf", Sweep(20, 10, 0.9), options, {}, asked.Hooks());
  const double estimate =
      ViewsEstimate::Of(*options.cap, *DiscRadius({600, 1, kSubject.radius, options.threshold_px}),
                        options.until_share)
          .usual;
  EXPECT_NEAR(*asked.states.front()->views_expected / estimate, 1, 0.05);
  const CaptureState& last = *asked.states.back();
  EXPECT_NEAR(*last.views_expected,
              static_cast<double>(last.view_ids.size()) +
                  std::max(0.0, 1 - *last.covered / options.until_share) * estimate,
              1);
  EXPECT_THAT(asked.said,
              Contains(AllOf(HasSubstr(" at 7 px within the cap"), HasSubstr("; keep at least"))));
}

}  // namespace
}  // namespace ulf::test::capture_requests_test
