// The display without a window: lines press its keys, and what it shows comes out as files.
#include "coverage/operator/scripted_surface.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/error.h"
#include "acquisition/light_field_io.h"
#include "coverage/operator/operator_display.h"
#include "tests/support/staged_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

double Difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

TEST(DisplayScript, TakesItsOwnLinesAndRefusesWhatCannotBe) {
  const ScratchFolder scratch;
  DisplayScript script;
  for (const char* line : {"take-back 3", "pressed", "looking x.png", "", "  ", "finish"})
    EXPECT_FALSE(script.Take(line)) << line;
  EXPECT_FALSE(script.Next());
  EXPECT_TRUE(script.Take("  press s,Shift+Up,Space,Delete \r"));
  EXPECT_TRUE(script.Take("look " + (scratch / "with a blank.png").string()));
  const auto keys = script.Next(), look = script.Next();
  ASSERT_EQ(std::get<DisplayScript::Keys>(*keys).size(), 4u);
  EXPECT_TRUE(std::get<KeyPressed>(std::get<DisplayScript::Keys>(*keys)[1]).shift);
  EXPECT_EQ(std::get<Typed>(std::get<DisplayScript::Keys>(*keys)[2]).character, U' ');
  EXPECT_EQ(std::get<DisplayScript::Look>(*look), scratch / "with a blank.png");
  for (const char* line : {"press nokey", "look", "look picture.txt", "look /nowhere/at/all.png"})
    EXPECT_THROW(script.Take(line), UsageError) << line;
  EXPECT_FALSE(script.Next());
}

// Each picture is of what the lines before it asked for, and of nothing after it.
TEST(ScriptedSurface, ShowsWhatWasPressed) {
  const ScratchFolder scratch;
  const auto file = [&](const char* name) { return (scratch / name).string(); };
  StagedCapture capture;
  const auto script = std::make_shared<DisplayScript>();
  CaptureFeed feed;
  CaptureRequests requests;
  const auto lines = {"look " + file("live.png"), std::string("press ?"),      "look " + file("keys.png"),
                      std::string("press ?"),     "look " + file("again.png"), "look " + file("last.png")};
  {
    ScriptedSurface surface({320, 240}, script);
    OperatorDisplay display(surface, feed, requests);
    feed.Publish(capture.At(capture.CameraAt(0, 0)));
    for (const std::string& line : lines) ASSERT_TRUE(script->Take(line));
    for (int i = 0; i < 5 * (ScriptedSurface::kFramesBetween + 1) + 1; ++i) display.Step();
    EXPECT_FALSE(std::filesystem::exists(file("last.png"))) << "not its turn";
  }
  const cv::Mat live = cv::imread(file("live.png")), keys = cv::imread(file("keys.png"));
  ASSERT_EQ(live.size(), cv::Size(320, 240));
  EXPECT_GT(Difference(live, keys), 10);
  EXPECT_LT(Difference(live, cv::imread(file("again.png"))), 0.5);
  EXPECT_LT(Difference(live, cv::imread(file("last.png"))), 0.5) << "the display's last picture";
}

// As somebody far away would: the program, without a screen.
TEST(OffscreenCapture, IsPressedAndLookedAt) {
  const ScratchFolder scratch;
  const std::string picture = (scratch / "review.png").string(), lines = (scratch / "lines").string();
  std::ofstream(lines) << "press r\nlook " << picture << "\nlook no.txt\n";
  const std::string capture =
      "capture 'sim:studio?width=320&height=240&look_away=0' --poses known "
      "--subject 0,0,0.07,0.162 --frames 25 -o " +
      (scratch / "lf").string();
  const CommandResult alone = RunUlf(capture + " --offscreen");
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.errors, HasSubstr("--requests"));
  const CommandResult run = RunUlf(capture + " --offscreen --requests " + lines);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, AllOf(HasSubstr("look " + picture + ": written"), HasSubstr("no.txt")));
  EXPECT_EQ(cv::imread(picture).size(), cv::Size(1280, 720));
  EXPECT_GT(ReadLightField(scratch / "lf").views.size(), 1u);
}

}  // namespace
}  // namespace ulf::test
