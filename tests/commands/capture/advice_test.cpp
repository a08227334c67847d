// Tests: core/frames/frame, coverage/session/watch/mistake_watch, coverage/session/preflight,
// tracking/tracker/track, commands/capture/capture_report, commands/reports/light_field_report.
//
// Advice names only what can still be changed: everything that is said, of every kind of source. Nobody can
// move, set or light what took pictures that are there already; the simulator has no `ulf features`.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <regex>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "commands/capture/capture_report.h"
#include "commands/reports/check_reports.h"
#include "core/base/error.h"
#include "core/geometry/rigid3.h"
#include "coverage/operator/instruction.h"
#include "coverage/operator/panels.h"
#include "coverage/session/cap_watch.h"
#include "coverage/session/capture_subject.h"
#include "coverage/session/preflight.h"
#include "coverage/session/turn_back.h"
#include "coverage/session/turntable_watch.h"
#include "coverage/session/watch/mistake_watch.h"
#include "tests/support/floors.h"
#include "tracking/tracker/track.h"

namespace ulf::advice_test {
namespace {

using ::testing::HasSubstr;

// What only somebody with a camera, lamps and a subject at hand can do.
const std::regex kForTheHand(
    "\\bmove (it|the|slow|side|more)|move on until|to move\\b|[,:;] move|\\bslower\\b|\\b[Hh]old |sideways|"
    "\\bgo (back|nearer|on a)|\\bnearer\\b|\\bcome [0-9n]|\\bwait\\b|\\baim at|turn (round|the|[0-9])|"
    "\\bstep back|walk on|the arrow|put it back|\\bshow (more|a part|another|something)|more light|add light|"
    "\\b[Ee]xpose\\b|[Cc]lean|\\block\\b|ulf features|[Ss]witch|[Ff]ocus on|set the exposure|ulf calibrate|"
    "[Cc]alibrate (with|the)|let it stand|start the turntable|stay (at|[0-9])|[Kk]eep lamps|warm up|bring "
    "the\\b");

// What is said of the next pictures is marked as such.
std::string OfThesePictures(const std::string& words) {
  const std::size_t next = words.find("he next time ");
  return next == std::string::npos ? words : words.substr(0, next);
}

void ExpectToFit(FrameSource source, const std::string& words) {
  const std::string of_these = OfThesePictures(words);
  std::smatch found;
  if (IsTaken(source) && std::regex_search(of_these, found, kForTheHand))
    ADD_FAILURE() << "'" << found.str() << "' of pictures that are taken already: " << words;
  if (source != FrameSource::kSettableCamera && words.find("ulf features") != std::string::npos)
    ADD_FAILURE() << "there is nothing that ulf features could set: " << words;
}

tracking::CalibrationCheck WrongLens() {
  return {
      .given_focal_px = 525, .fitted_focal_px = 500, .sigma_px = 1, .determined = true, .focal_wrong = true};
}

constexpr StartObstacle kObstacles[]{
    StartObstacle::kNone,           StartObstacle::kFirstView,          StartObstacle::kTooFewFeatures,
    StartObstacle::kTooFewMatches,  StartObstacle::kRotationOnly,       StartObstacle::kLowParallax,
    StartObstacle::kAmbiguousPlane, StartObstacle::kConflictingMotions, StartObstacle::kMapDidNotHold};

TEST(Advice, FromTheTrackerFitsTheSource) {
  for (const FrameSource source : kFrameSources) {
    std::vector<std::string> said{ZoomInWords(1.1, source), WrongLens().Advice(source)};
    CalibrationCheck check = WrongLens();
    check.rows_uncompensated = true;
    said.push_back(check.Advice(source));
    check.no_lens_fits = true;
    said.push_back(check.Advice(source));
    for (const StartObstacle obstacle : kObstacles) {
      said.push_back(tracking::Advice(obstacle, source));
      for (const TrackState state :
           {TrackState::kInitializing, TrackState::kTracking, TrackState::kApart, TrackState::kLost})
        for (const bool turns : {false, true}) {
          Track track;
          track.state = state;
          said.push_back(InWords(track, source));
          track.features = 12;
          said.push_back(InWords(track, source));
          track.features = 700;
          if (turns) track.turn = Eigen::Quaterniond::Identity();
          said.push_back(InWords(track, source));
          track.start = StartProgress{obstacle, 0.3, 0.8, 12, 60};
          said.push_back(InWords(track, source));
          const CameraTurn turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY())), true};
          said.push_back(InWords(track, turned, source));
        }
    }
    for (const std::string& words : said) {
      EXPECT_FALSE(words.empty());
      ExpectToFit(source, words);
    }
  }
  EXPECT_THAT(tracking::Advice(StartObstacle::kRotationOnly, FrameSource::kCamera), HasSubstr("sideways"));
}

TEST(Advice, OnMistakesAndPreflightFitsTheSource) {
  for (const FrameSource source : kFrameSources) {
    for (const Mistake mistake : kMistakes)
      for (const bool compensated : {false, true}) {
        EXPECT_FALSE(CureOf(mistake, source, compensated).empty());
        ExpectToFit(source, CureOf(mistake, source, compensated));
      }
    PreflightInput input;
    input.source = source;
    input.calibrated = false;
    input.prediction = CapturePrediction{
        .disc_radius = 0.00001, .nearest = 0.5, .farthest = 2, .views = ViewsEstimate{2e5, 2e5, 2e5}};
    const auto expect_all_to_fit = [&] {
      for (const PreflightItem& item : Preflight(input)) ExpectToFit(source, item.words);
    };
    input.picture.light = SubjectLight{.brightest_tenth = 0.03};
    expect_all_to_fit();
    input.picture.light = SubjectLight{.clipped_share = 1, .brightest_tenth = 1, .brightest_hundredth = 1};
    input.held = {.exposure = false, .white_balance = false, .focus = false};
    input.lens_contradicted = WrongLens();
    input.pose_error_px = 5;
    expect_all_to_fit();
    input.picture.fine_detail = 0.3;
    input.lens_is_sought = true;
    expect_all_to_fit();
    ExpectToFit(source, InWords(*input.prediction, 12, true, source));
    input.prediction->farthest.reset();
    ExpectToFit(source, InWords(*input.prediction, 12, true, source));
    ExpectToFit(source, ThresholdWarning(*input.prediction, {}, source).value());
  }
}

TEST(Advice, OnTheDisplayFitsTheSource) {
  for (const FrameSource source : kFrameSources) {
    CaptureState state;
    state.source = source;
    ExpectToFit(source, InWords(InstructionFor(state), state));
    state.cam_from_world = LookAt({0, 0, -2}, {0, 0, 0}, {0, -1, 0});
    state.tracking = TrackState::kTracking;
    for (const bool finding : {false, true}) {
      state.finding_subject = finding;
      ExpectToFit(source, InWords(InstructionFor(state), state));
    }
    state.subject = Subject{{0, 0, 0}, 0.2};
    state.subject_moved = true;
    ExpectToFit(source, InWords(InstructionFor(state), state));
    state.subject_moved = false;
    state.guidance.toward = Eigen::Vector3d(1, 0, -1).normalized();
    for (const double distance : {1.0, 2.0, 4.0})
      for (const Reason reason : kReasons) {
        state.guidance.distance = distance;
        state.guidance.row = Guidance::RowOffset{0.2, 0.1};
        state.decision.reason = reason;
        ExpectToFit(source, InWords(InstructionFor(state), state));
      }
    EXPECT_EQ(WayInWords(state).empty(), IsTaken(source));
    state.subject.reset();
    state.without_subject = true;
    state.decision.reason = Reason::kRecorded;
    ExpectToFit(source, InWords(InstructionFor(state), state));
    const Rigid3 at_origin;
    for (const Subject& subject : {Subject{{0, 0, 1}, 1.5}, Subject{{0, 0, -1}, 0.2}})
      ExpectToFit(source, ProblemOf(subject, at_origin, source));
  }
}

TEST(Advice, OnATurntableFitsTheSource) {
  for (const FrameSource source : kFrameSources) {
    TurntableWatch unseen("charuco:5x5:54:40:DICT_4X4_50", source),
        still("charuco:5x5:54:40:DICT_4X4_50", source);
    std::string said;
    for (double time_s = 0; time_s < 6; time_s += 0.1)
      said += unseen.Update(time_s, std::nullopt) +
              still.Update(time_s, LookAt({0, 0, -2}, {0, 0, 0}, {0, -1, 0}));
    EXPECT_THAT(said, HasSubstr("is not seen"));
    EXPECT_THAT(said, HasSubstr("does not turn"));
    ExpectToFit(source, said);
  }
}

TEST(Advice, AtTheEndOfACaptureFitsTheSource) {
  for (const FrameSource source : kFrameSources) {
    for (const Reason reason : kReasons) {
      CaptureSummary summary;
      summary.source = source;
      summary.frames = 300;
      summary.reasons[static_cast<std::size_t>(reason)] = 250;
      ExpectToFit(source, NothingRecorded(summary, 300));
      summary.recorded = 7;
      ExpectToFit(source, FewRecordedReason(summary));
      summary.calibration = WrongLens();
      ExpectToFit(source, ToText(summary, 300, "vase"));
    }
    for (const StartObstacle obstacle : kObstacles) {
      CaptureSummary summary;
      summary.source = source;
      summary.frames = 30;
      summary.start_obstacles = {{obstacle, 30}};
      ExpectToFit(source, NothingRecorded(summary, 0));
    }
    ExpectToFit(source, LampAdvice({.drifts = {LampDrift{.difference = -0.1}}}, source));
  }
}

// A device of which no live frame will ever come.
class WithoutLiveView : public Device {
 public:
  explicit WithoutLiveView(FrameSource source) : source_(source) {}
  DeviceInfo Info() const override {
    return {.uri = "gphoto2:usb", .maker = {}, .model = {}, .serial = {}, .bus = {}, .problem = {}};
  }
  bool IsLive() const override { return true; }
  FrameSource Source() const override { return source_; }
  bool HasLiveFrames() const override { return false; }
  void Start() override {}
  std::optional<Frame> Next(std::chrono::milliseconds /*timeout*/) override { return std::nullopt; }
  void Stop() override {}
  DeviceState State() const override { return DeviceState::kStreaming; }
  DeviceStatistics Statistics() const override { return {}; }

 private:
  const FrameSource source_;
};

TEST(Advice, OnLightHasOneFigureAndTheMeshItNeeds) {
  using Kind = LampDrift::Kind;
  const LightCheck check{
      .drifts = {{Kind::kBrightness, 0.05, 0.01, 1, 5, 6, 10}, {Kind::kBlueness, -0.4, 0.01, 1, 3, 4, 10}},
      .fluctuations = {{Kind::kGreenness, 0.6}}};
  const std::string advice = LampAdvice(check, FrameSource::kRecording);
  EXPECT_EQ(std::ranges::count(advice, '%'), 1) << advice;
  EXPECT_THAT(advice, testing::AllOf(testing::HasSubstr("views 4 to 10 are 49 % redder"),
                                     testing::HasSubstr("'ulf proxy DIR'"), testing::HasSubstr("--light fit"),
                                     testing::HasSubstr("--light even")));
  EXPECT_THAT(LampAdvice({.fluctuations = check.fluctuations}, FrameSource::kRecording),
              testing::HasSubstr("goes up and down by 82 %"));
  EXPECT_EQ(LampAdvice({}, FrameSource::kRecording), "");
}

TEST(Advice, WithoutLiveViewNamesPhotographs) {
  for (const FrameSource source : kFrameSources) try {
      RequireLiveFrames(WithoutLiveView(source));
      ADD_FAILURE() << "waits for ever";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("ulf import"));
      EXPECT_EQ(std::string(error.what()).find("ulf record") == std::string::npos, IsTaken(source));
      ExpectToFit(source, error.what());
    }
}

}  // namespace
}  // namespace ulf::advice_test
