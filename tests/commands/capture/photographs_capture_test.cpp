// Tests: commands/capture/capture_closing, coverage/session/prepared_capture,
// core/light_field/folder/unused_folder.
//
// `ulf capture replay:FOLDER` tells single photographs from frames, and a recording whose lens nobody knows
// is tracked with the lens that its pictures tell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/light_field/folder/light_field_io.h"
#include "core/video/video_writer.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"

namespace ulf::photographs_capture_test {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::Furniture;
using test::RunUlf;
using test::TexturedRoom;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const CameraModel kCamera = CameraModel::Pinhole(480, 360, 390);

class PhotographsCapture : public testing::Test {
 protected:
  PhotographsCapture() { fs::create_directories(Folder()); }
  fs::path Folder() const { return scratch_ / "photographs"; }
  fs::path Dir() const { return scratch_ / "lf"; }
  void Add(const TexturedRoom& room, const Rigid3& pose) {
    cv::imwrite((Folder() / fmt::format("{:04}.png", count_)).string(),
                room.Take(pose, static_cast<std::uint64_t>(count_), kCamera).image.pixels);
    ++count_;
  }
  CommandResult Capture(const std::string& uri, const std::string& more) const {
    return RunUlf("capture " + uri + " -o " + Dir().string() +
                  " --headless --deterministic --no-geometry --no-subject " + more);
  }
  const test::ScratchFolder scratch_;
  int count_ = 0;
};

TEST_F(PhotographsCapture, FailsWhereTheyAreUnordered) {
  // Some neighbours are near: the tracker may begin with them.
  const TexturedRoom room({.furniture = Furniture::kRound, .seed = 2});
  for (int i = 0; i < 8; ++i) Add(room, TexturedRoom::RoundAt(3 * i));
  for (int i = 0; i < 20; ++i) Add(room, TexturedRoom::RoundAt(30 + 18 * (7 * i % 20)));
  const CommandResult run = Capture("replay:" + Folder().string(), "--focal-px 390");
  EXPECT_EQ(run.exit_code, 1) << run.errors;
  EXPECT_THAT(run.errors, AllOf(HasSubstr("do not follow one another"),
                                HasSubstr("ulf import " + Folder().string() + " --pose -o DIR")));
}

// The cause may be any.
TEST_F(PhotographsCapture, ThatRecordNothingLeadToImport) {
  for (int i = 0; i < 3; ++i)
    cv::imwrite((Folder() / fmt::format("{}.png", i)).string(), cv::Mat(360, 480, CV_8UC1, 90.0));
  const CommandResult run = Capture("replay:" + Folder().string(), "--focal-px 390");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was recorded"), Not(HasSubstr("see the message")),
                                HasSubstr("ulf import " + Folder().string() + " --pose -o DIR")));
  EXPECT_FALSE(fs::exists(Dir())) << "nothing is left of it";
}

TEST_F(PhotographsCapture, FramesOfALostCameraAreFrames) {
  const TexturedRoom room({.seed = 2}), other({.furniture = Furniture::kRound, .seed = 9});
  for (int i = 0; i < 40; ++i) Add(room, TexturedRoom::HandAt(2 * i));
  for (int i = 0; i < 60; ++i) Add(other, TexturedRoom::TurningAt(i));  // turns alone, elsewhere
  const CommandResult run = Capture("replay:" + Folder().string(), "--focal-px 390");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, Not(HasSubstr("ulf import")));
  EXPECT_GT(ReadLightField(Dir()).views.size(), 1u);
}

TEST_F(PhotographsCapture, AFewFramesASecondAreFrames) {
  const TexturedRoom room({.seed = 3});
  for (int i = 0; i < 40; ++i) Add(room, TexturedRoom::HandAt(6 * i));
  const CommandResult run = Capture("'replay:" + Folder().string() + "?fps=5'", "--focal-px 390");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, Not(HasSubstr("ulf import")));
}

TEST_F(PhotographsCapture, OtherSizesAreSentToImport) {
  const TexturedRoom room({});
  for (int i = 0; i < 3; ++i) Add(room, TexturedRoom::HandAt(i));
  cv::imwrite((Folder() / "9999.png").string(),
              room.Take(TexturedRoom::HandAt(3), 3, kCamera).image.pixels.t());
  const CommandResult run = Capture("replay:" + Folder().string(), "--focal-px 390");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("mixed images"),
                                HasSubstr("ulf import " + Folder().string() + " --pose -o DIR")));
}

// As a telephone's, of which nothing is known.
class VideoCapture : public PhotographsCapture {
 protected:
  std::string Video(int frames, bool stands = false) const {
    const std::string file = (scratch_ / "walk.mp4").string();
    const TexturedRoom room({});
    VideoWriter writer(file, {640, 480}, 30);
    for (int i = 0; i < frames; ++i) {
      cv::Mat colors;
      cv::cvtColor(
          room.Take(TexturedRoom::HandAt(stands ? 0 : i), static_cast<std::uint64_t>(i)).image.pixels, colors,
          cv::COLOR_GRAY2BGR);
      writer.Add(colors);
    }
    writer.Close();
    return "replay:" + file;
  }
};

TEST_F(VideoCapture, FindsTheLensThatNobodyKnows) {
  const CommandResult run = Capture(Video(90), "");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("a focal length of 544 px is guessed"));
  for (const char* word : {"board", "target", "calibrate", "Calibrate"})
    EXPECT_THAT(run.errors + run.output, Not(HasSubstr(word)));
  EXPECT_NEAR(ReadLightField(Dir()).cameras.at(0).fx, 520, 0.015 * 520);
}

TEST_F(VideoCapture, ThatStandsStillSaysWhyThereIsNoPose) {
  const CommandResult run = Capture(Video(45, true), "--focal-px 520");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("pose is not known: "), HasSubstr("parallax"),
                                HasSubstr("nothing was recorded"), Not(HasSubstr("see the message")),
                                Not(HasSubstr("ulf import"))));
  EXPECT_FALSE(fs::exists(Dir()));
}

TEST_F(VideoCapture, KeepsALensThatIsGiven) {
  const std::string video = Video(60);
  const CommandResult given = Capture(video, "--focal-px 546");
  ASSERT_EQ(given.exit_code, 0) << given.errors;
  EXPECT_THAT(given.errors, Not(HasSubstr("guessed")));
  EXPECT_EQ(ReadLightField(Dir()).cameras.at(0).fx, 546);
  for (const char* use : {"check", "fixed"}) {
    fs::remove_all(Dir());
    const CommandResult asked = Capture(video, std::string("--intrinsics ") + use);
    EXPECT_EQ(asked.exit_code, 1) << "nothing is known, and nothing may be sought";
    EXPECT_THAT(asked.errors, AllOf(HasSubstr("intrinsics are not known"), Not(HasSubstr("board"))));
  }
}

}  // namespace
}  // namespace ulf::photographs_capture_test
