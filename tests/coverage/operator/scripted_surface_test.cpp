// Tests: coverage/operator/scripted_surface.
//
// The display without a window: lines press its keys, and what it shows comes out as files.
#include "coverage/operator/scripted_surface.h"
#include "core/base/json_text.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/operator/operator_display.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test::scripted_surface_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

double Difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

TEST(DisplayScript, KeepsOrderAndRefusesInvalidLines) {
  const ScratchFolder scratch;
  CaptureRequests requests;
  DisplayScript script(requests);
  EXPECT_FALSE(script.Next());
  script.Take("  press s,Shift+Up,Space,Delete \r");
  script.Take("look " + (scratch / "with a blank.png").string());
  script.Take("take-back 3");
  for (const char* line : {"press nokey", "press", "look", "look picture.txt", "look /nowhere/at/all.png",
                           "pressed", "looking x.png", "", "nothing"})
    EXPECT_THROW(script.Take(line), Refusal) << line;
  const auto keys = script.Next(), look = script.Next(), request = script.Next();
  ASSERT_EQ(std::get<DisplayScript::Keys>(*keys).size(), 4u);
  EXPECT_TRUE(std::get<KeyPressed>(std::get<DisplayScript::Keys>(*keys)[1]).shift);
  EXPECT_EQ(std::get<Typed>(std::get<DisplayScript::Keys>(*keys)[2]).character, U' ');
  EXPECT_EQ(std::get<DisplayScript::Look>(*look), scratch / "with a blank.png");
  EXPECT_EQ(std::get<TakeBackLast>(std::get<CaptureRequest>(*request)).count, 3);
  EXPECT_FALSE(script.Next());
}

// Whatever becomes of the display, what is asked of the capture is not lost.
TEST(DisplayScript, SendsRequestsWithoutADisplay) {
  const ScratchFolder scratch;
  CaptureRequests requests;
  DisplayScript script(requests);
  script.Take("pause");
  script.Take("look " + (scratch / "never.png").string());
  EXPECT_TRUE(requests.Take().empty()) << "in their turn";
  ::testing::internal::CaptureStderr();
  script.End();
  script.Take("finish");
  script.Take("press s");
  const std::string said = ::testing::internal::GetCapturedStderr();
  const auto asked = requests.Take();
  ASSERT_EQ(asked.size(), 2u);
  EXPECT_FALSE(std::get<SetRecording>(asked[0]).on);
  EXPECT_TRUE(std::holds_alternative<FinishCapture>(asked[1]));
  EXPECT_THAT(said,
              AllOf(HasSubstr("never.png: there is no display"), HasSubstr("press: there is no display")));
}

// Each picture is of what the lines before it asked for, and of nothing after it; requests wait for their
// turn.
TEST(ScriptedSurface, ShowsWhatWasPressed) {
  const ScratchFolder scratch;
  const auto file = [&](const char* name) { return (scratch / name).string(); };
  StagedCapture capture;
  CaptureFeed feed;
  CaptureRequests requests;
  const auto script = std::make_shared<DisplayScript>(requests);
  ::testing::internal::CaptureStderr();
  {
    ScriptedSurface surface({320, 240}, script);
    OperatorDisplay display(surface, feed, requests);
    feed.Publish(capture.At(capture.CameraAt(0, 0)));
    for (const std::string& line :
         {"look " + file("live.png"), std::string("press ?"), "look " + file("keys.png"),
          std::string("finish"), "look " + file("last.png")})
      script->Take(line);
    for (int i = 0; i < 3 * (ScriptedSurface::kFramesBetween + 1); ++i) display.Step();
    EXPECT_TRUE(std::filesystem::exists(file("keys.png")));
    EXPECT_TRUE(requests.Take().empty()) << "not its turn";
    for (int i = 0; i < ScriptedSurface::kFramesBetween + 1; ++i) display.Step();
    EXPECT_EQ(requests.Take().size(), 1u);
    EXPECT_FALSE(std::filesystem::exists(file("last.png"))) << "not its turn";
  }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("last.png: written as the display ended"));
  const cv::Mat live = cv::imread(file("live.png")), keys = cv::imread(file("keys.png"));
  ASSERT_EQ(live.size(), cv::Size(320, 240));
  EXPECT_GT(Difference(live, keys), 10);
  EXPECT_LT(Difference(keys, cv::imread(file("last.png"))), 0.5) << "the display's last picture";
}

// As somebody far away would: the program, without a screen.
TEST(OffscreenCapture, IsPressedAndLookedAt) {
  const ScratchFolder scratch;
  const std::string lines = (scratch / "lines").string();
  const auto picture = [&](const char* name) { return (scratch / name).string(); };
  std::ofstream(lines) << "record\nlook " << picture("live.png") << "\npress ?\nlook " << picture("keys.png")
                       << "\nlook no.txt\nfinish\n";
  const std::string capture =
      "capture --no-geometry 'sim:studio?width=320&height=240&look_away=0' --poses known "
      "--subject 0,0,0.07,0.162 --frames 3000 -o " +
      (scratch / "lf").string();
  const CommandResult alone = RunUlf(capture + " --offscreen");
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.errors, HasSubstr("--requests"));
  const CommandResult run = RunUlf(capture + " --offscreen --requests " + lines + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(JsonFromText(run.output)["stopped_because"], "closed") << "in its turn, after the pictures";
  EXPECT_THAT(run.errors, AllOf(HasSubstr("keys.png: written\n"), HasSubstr("no.txt")));
  const cv::Mat live = cv::imread(picture("live.png")), keys = cv::imread(picture("keys.png"));
  ASSERT_EQ(live.size(), cv::Size(1280, 720));
  EXPECT_GT(Difference(live, keys), 10);
  EXPECT_GT(ReadLightField(scratch / "lf").views.size(), 1u);
}

}  // namespace
}  // namespace ulf::test::scripted_surface_test
