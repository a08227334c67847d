// Tests: commands/capture/capture_report.
//
// What the operator reads at the end of a capture.
#include "commands/capture/capture_report.h"
#include "tests/support/floors.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace ulf::capture_report_test {
namespace {
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

CaptureSummary With(Reason reason, std::uint64_t frames) {
  CaptureSummary summary;
  summary.source = FrameSource::kSettableCamera;
  summary.frames = frames;
  summary.reasons[static_cast<std::size_t>(reason)] = frames;
  return summary;
}

TEST(CaptureReport, SaysWhichLimitEndedIt) {
  CaptureSummary summary;
  for (const auto& [why, words, name] : {std::tuple{StoppedBecause::kFrames, "--frames", "frames"},
                                         {StoppedBecause::kSeconds, "--max-seconds", "seconds"},
                                         {StoppedBecause::kEnded, "the device has no more frames", "ended"},
                                         {StoppedBecause::kSignal, "asked to", "signal"},
                                         {StoppedBecause::kDeviceLost, "the device is lost", "device_lost"},
                                         {StoppedBecause::kDisk, "the disk", "disk"},
                                         {StoppedBecause::kCovered, "the cap is covered", "covered"}}) {
    summary.stopped_because = why;
    EXPECT_THAT(ToText(summary, 0, "vase"), HasSubstr(std::string("\nended          ") + words));
    nlohmann::json json;
    AddTo(json, summary, 0);
    EXPECT_EQ(json["stopped_because"], name);
  }
}

TEST(CaptureReport, SaysWrongLensAndRollingShutter) {
  CaptureSummary summary;
  EXPECT_THAT(ToText(summary, 0, "vase"), AllOf(Not(HasSubstr("calibration")), Not(HasSubstr("shutter"))));
  summary.calibration = CalibrationCheck{
      .given_focal_px = 525, .fitted_focal_px = 500, .sigma_px = 1, .determined = true, .focal_wrong = true};
  summary.rolling_shutter = Readout{.readout_s = 0.02, .sigma_s = 0.001, .compensated = false};
  EXPECT_THAT(ToText(summary, 0, "vase"),
              AllOf(HasSubstr("500.0 px"), HasSubstr("ulf refine"), HasSubstr("readout_ms 20")));
  nlohmann::json json;
  AddTo(json, summary, 0);
  EXPECT_EQ(json["calibration"]["wrong"], true);
  EXPECT_NEAR(json["rolling_shutter"]["readout_ms"].get<double>(), 20, 1e-9);
}

TEST(CaptureReport, MistakesAreSaidOnceEachWithTheirCure) {
  CaptureSummary summary = With(Reason::kUnsettled, 20);
  summary.mistakes = {{.mistake = coverage::Mistake::kFlicker,
                       .finding = "the light goes up and down",
                       .cure = "Take other lamps",
                       .first_s = 2.4,
                       .last_s = 9}};
  EXPECT_THAT(
      ToText(summary, 0, "vase"),
      HasSubstr(
          "mistake        flickering lamps: the light goes up and down. Take other lamps (from 2 s on)"));
  nlohmann::json json;
  AddTo(json, summary, 0);
  ASSERT_EQ(json["mistakes"].size(), 1u);
  EXPECT_EQ(json["mistakes"][0]["name"], "flickering lamps");
  EXPECT_EQ(json["mistakes"][0]["cure"], "Take other lamps");
  EXPECT_EQ(json["mistakes"][0]["first_s"], 2.4);
  const std::string nothing = NothingRecorded(summary, 20);
  EXPECT_THAT(nothing, AllOf(HasSubstr("for 20 of 20 frames the reason was 'flickering lamps'"),
                             HasSubstr("Take other lamps"), Not(HasSubstr("came to rest"))));
  summary.mistakes.clear();
  EXPECT_THAT(NothingRecorded(summary, 20), HasSubstr("never came to rest"));
}

TEST(CaptureReport, SaysOneInTheSingular) {
  CaptureSummary summary;
  summary.frames = summary.device.delivered = summary.device.reconnects = summary.pauses = 1;
  EXPECT_THAT(ToText(summary, 1, "vase"),
              AllOf(HasSubstr("1 frame delivered"), HasSubstr("reconnected 1 time\n"),
                    HasSubstr("paused 1 time,"), HasSubstr("this session   1 frame, 1 tracked")));
  summary.frames = summary.device.delivered = summary.device.reconnects = summary.pauses = 2;
  EXPECT_THAT(ToText(summary, 1, "vase"),
              AllOf(HasSubstr("2 frames delivered"), HasSubstr("reconnected 2 times\n"),
                    HasSubstr("paused 2 times,"), HasSubstr("this session   2 frames,")));
}

TEST(CaptureReport, MissingGeometryNamesItsCommand) {
  CaptureSummary summary;
  FinishedGeometry geometry;
  auto mesh = std::make_shared<LiveMesh>();
  mesh->mesh = std::make_shared<const TriangleMesh>();
  geometry.mesh = mesh;
  geometry.maps = 5, geometry.missing_maps = 3;
  summary.geometry = geometry;
  EXPECT_THAT(ToText(summary, 0, "my vase"),
              HasSubstr("there was no time for 3 more depth maps; 'ulf proxy \"my vase\"' makes them all\n"));
}

TEST(CaptureReport, DroppedFramesNameTheReason) {
  EXPECT_THAT(ToText(CaptureSummary{}, 0, "vase"), HasSubstr("0 dropped (processing too slow), 0 missing"));
}

TEST(CaptureReport, FewViewsAreExplainedWithAdvice) {
  CaptureSummary walk = With(Reason::kOutsideRectangle, 174);
  walk.frames = 300, walk.recorded = 7, walk.subject_was_found = true;
  EXPECT_THAT(FewRecordedReason(walk), AllOf(HasSubstr("only 7 of 300 frames recorded: for 174"),
                                             HasSubstr("safety rectangle"), HasSubstr("placed by itself"),
                                             HasSubstr("--subject x,y,z,radius"), HasSubstr("--no-subject")));
  walk.subject_was_found = false;
  EXPECT_THAT(FewRecordedReason(walk), Not(HasSubstr("by itself")));
  CaptureSummary dark = With(Reason::kExposure, 200);
  dark.frames = 300, dark.recorded = 7;
  EXPECT_THAT(FewRecordedReason(dark), AllOf(HasSubstr("ulf features"), Not(HasSubstr("--no-subject"))));
  dark.recorded = 0;
  EXPECT_THAT(FewRecordedReason(dark), HasSubstr("nothing was recorded of 300 frames: for 200")) << "resumed";
  CaptureSummary good = With(Reason::kCovered, 290);
  good.frames = 300, good.recorded = 10;
  EXPECT_EQ(FewRecordedReason(good), "");
  CaptureSummary wide = With(Reason::kOutsideRectangle, 120);
  wide.frames = 300, wide.recorded = 120, wide.reasons[static_cast<std::size_t>(Reason::kBlur)] = 60;
  EXPECT_EQ(FewRecordedReason(wide), "") << "many were recorded";
  walk.stopped_because = StoppedBecause::kCovered;
  EXPECT_EQ(FewRecordedReason(walk), "") << "all that was wanted is there";
}

TEST(CaptureReport, ElsewhereReasonsCountTogether) {
  const auto with = [](std::uint64_t outside, std::uint64_t inside, std::uint64_t lost) {
    CaptureSummary summary = With(Reason::kOutsideRectangle, outside);
    summary.reasons[static_cast<std::size_t>(Reason::kInsideSphere)] = inside;
    summary.reasons[static_cast<std::size_t>(Reason::kTracking)] = lost;
    summary.frames = 300, summary.recorded = 7;
    return summary;
  };
  EXPECT_THAT(FewRecordedReason(with(130, 60, 103)),
              AllOf(HasSubstr("only 7 of 300 frames recorded: for 190"), HasSubstr("safety rectangle"),
                    HasSubstr(std::string("' or '") + InWords(Reason::kInsideSphere)),
                    HasSubstr("--subject x,y,z,radius")));
  EXPECT_THAT(FewRecordedReason(with(80, 60, 153)),
              AllOf(HasSubstr("for 153"), HasSubstr(InWords(Reason::kTracking)), HasSubstr("sideways"),
                    Not(HasSubstr("--no-subject"))));
  CaptureSummary covered = with(80, 60, 103);
  covered.reasons[static_cast<std::size_t>(Reason::kCovered)] = 5000;
  covered.frames = 5250;
  EXPECT_EQ(FewRecordedReason(covered), "") << "nearly all of it is there";
}

TEST(CaptureReport, TransportCountersFitTheTerminal) {
  CaptureSummary summary;
  for (int i = 0; i < 30; ++i)
    summary.device.transport.emplace_back(static_cast<acquisition::TransportFigure>(i),
                                          i % 3 == 0 ? 0 : 1000 + i);
  const std::string text = ToText(summary, 0, "vase");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110u) << line;
  EXPECT_THAT(text, AllOf(HasSubstr("frames completed 1001"), HasSubstr("resend on 1029"),
                          Not(HasSubstr("packet size negotiated "))));
}

TEST(CaptureReport, NoViewNamesTheCommonestReason) {
  EXPECT_THAT(NothingRecorded({}, 0), HasSubstr("no complete frame came"));
  EXPECT_THAT(NothingRecorded(With(Reason::kTracking, 30), 0),
              AllOf(HasSubstr("in none of 30 frames"), HasSubstr("sideways")));
  CaptureSummary turning = With(Reason::kTracking, 30);
  turning.start_obstacles = {{StartObstacle::kFirstView, 1}, {StartObstacle::kRotationOnly, 29}};
  EXPECT_THAT(NothingRecorded(turning, 0), HasSubstr("(in 29 of them: the camera only turns"));
  for (const auto& [reason, words] : {std::pair{Reason::kBlur, "expose shorter"},
                                      {Reason::kExposure, "ulf features"},
                                      {Reason::kOutsideRectangle, "--subject-size"},
                                      {Reason::kSpeed, "move slower"},
                                      {Reason::kSpool, "faster"},
                                      {Reason::kTracking, "sideways"}}) {
    CaptureSummary summary = With(reason, 20);
    summary.frames = 30;
    summary.reasons[static_cast<std::size_t>(Reason::kBehind)] = 10;
    EXPECT_THAT(NothingRecorded(summary, 30),
                AllOf(HasSubstr("20 of 30 frames"), HasSubstr(InWords(reason)), HasSubstr(words)));
  }
}

}  // namespace
}  // namespace ulf::capture_report_test
