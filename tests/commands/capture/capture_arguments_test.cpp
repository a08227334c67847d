// Tests: commands/capture/capture_start, coverage/session/capture_meters.

#include <gmock/gmock.h>

#include "commands/capture/capture_start.h"
#include "commands/options/command_line.h"
#include "core/base/error.h"
#include "coverage/session/capture_meters.h"
#include "tests/support/floors.h"

namespace ulf::test::capture_arguments_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(CaptureArguments, BecomeSessionOptions) {
  CaptureArgs args;
  EXPECT_EQ(OptionsFrom(args).threshold_px, 7);
  EXPECT_FALSE(OptionsFrom(args).cap);
  args.quality = "fast";
  args.until_covered = "60x40:90%";
  args.frames = 12;
  const CaptureOptions options = OptionsFrom(args);
  EXPECT_EQ(options.threshold_px, 12);
  EXPECT_NEAR(options.cap.value().Degrees().x(), 60, 1e-9);
  EXPECT_EQ(options.until_share, 0.9);
  EXPECT_EQ(options.max_frames, 12u);
  args.until_covered = "none";
  EXPECT_FALSE(OptionsFrom(args).cap);
}

TEST(CaptureArguments, OfATurntableBecomeAMarkerSource) {
  CaptureArgs args;
  args.turntable = "charuco:5x5:54:40:DICT_4X4_50";
  args.poses = PosesFrom(args);
  EXPECT_EQ(args.poses.Text(), "markers:charuco:5x5:54:40:DICT_4X4_50");
  const CaptureOptions options = OptionsFrom(args);
  ASSERT_TRUE(options.turntable);
  EXPECT_EQ(options.turntable->Text(), args.turntable);
  EXPECT_FALSE(options.geometry) << "it is made when the background is masked";

  const auto refused = [](const auto& change, const char* words) {
    CaptureArgs args;
    args.turntable = "charuco:5x5:54:40:DICT_4X4_50";
    EXPECT_THAT(
        [&] {
          change(args);
          args.poses = PosesFrom(args);
          OptionsFrom(args);
        },
        ThrowsMessage<Refusal>(HasSubstr(words)));
  };
  refused([](CaptureArgs& args) { args.poses_text = "known"; }, "leave out --poses");
  refused([](CaptureArgs& args) { args.no_subject = true; }, "leave out one of the two");
  refused([](CaptureArgs& args) { args.cover = "measured"; }, "leave out --cover");
  refused([](CaptureArgs& args) { args.error_map = "errors.png"; }, "leave out --cover and --error-map");
  refused([](CaptureArgs& args) { args.turntable = "marker:80:DICT_4X4_50"; }, "one marker's number");
  refused([](CaptureArgs& args) { args.turntable = "dots:3"; }, "markers 'dots:3'");
}

TEST(CaptureArguments, AreRefusedWhenContradictory) {
  const auto refused = [](const auto& change, const char* words) {
    CaptureArgs args;
    change(args);
    EXPECT_THAT([&] { OptionsFrom(args); }, ThrowsMessage<Refusal>(HasSubstr(words)));
  };
  refused([](CaptureArgs& args) { args.threshold_px = 2; }, "give more");
  refused([](CaptureArgs& args) { args.quality = "fast", args.threshold_px = 9; }, "give one");
  refused([](CaptureArgs& args) { args.parallax_deg = 2; }, "--no-subject");
  refused([](CaptureArgs& args) { args.no_subject = true, args.until_covered = "60x40"; }, "--until-covered");
  refused([](CaptureArgs& args) { args.subject_size = 0.9; }, "--subject-size");
  refused([](CaptureArgs& args) { args.coverage_width_px = 8; }, "--coverage-width");
}

// Over the last second, whatever came before, and anew where the camera's clock begins anew.
TEST(CaptureMeters, TellTheRecentRate) {
  CaptureMeters meters;
  EXPECT_FALSE(meters.FramesPerS());
  for (int i = 0; i <= 20; ++i) meters.FrameAt(0.1 * i);
  EXPECT_NEAR(meters.FramesPerS().value(), 10, 1e-6);
  for (int i = 1; i <= 60; ++i) meters.FrameAt(2 + i / 30.0);
  EXPECT_NEAR(meters.FramesPerS().value(), 30, 1e-6);
  meters.FrameAt(0);
  EXPECT_FALSE(meters.FramesPerS());
  meters.FrameAt(0.5);
  EXPECT_NEAR(meters.FramesPerS().value(), 2, 1e-6);
}

}  // namespace
}  // namespace ulf::test::capture_arguments_test
