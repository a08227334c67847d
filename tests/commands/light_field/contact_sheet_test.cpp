// Tests: commands/light_field/contact_sheet, commands/light_field/sheet_command.
//
// The contact sheet: its layout alone, and whole from a light field that the simulator gave.
#include "commands/light_field/contact_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::contact_sheet_test {
namespace {

TEST(ContactSheet, FitsPanelsWithoutDistortingThem) {
  const cv::Scalar red(0, 0, 255);
  const cv::Mat wide(50, 200, CV_8UC3, red);
  const cv::Mat sheet =
      ComposeSheet("headline", {{wide, "wide"}}, {.columns = 1, .cell_width_px = 100, .cell_height_px = 100});
  cv::Mat mask;
  cv::inRange(sheet, red, red, mask);
  EXPECT_EQ(cv::countNonZero(mask), 100 * 25) << "a quarter as high as wide, over the cell's whole width";
}

TEST(ContactSheet, NamesThePanelThatHasNoImage) {
  EXPECT_THAT(
      [] {
        ComposeSheet("headline", {{cv::Mat(), "coverage map"}});
      },
      testing::ThrowsMessage<Error>(testing::HasSubstr("coverage map")));
}

TEST(ContactSheet, IsMadeFromACapturedLightField) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), picture = (scratch / "sheet.png").string();
  const std::string live = (scratch / "live.png").string();
  const auto captured =
      test::RunUlf("capture --no-geometry 'sim:studio?width=160&height=120&row_deg=6&speed_deg_s=30' -o " +
                   dir + " --headless --poses known --subject 0,0,0.07,0.162 --threshold-px 12 --frames 150" +
                   " --overlay " + live);
  ASSERT_EQ(captured.exit_code, 0) << captured.errors;
  const auto drawn = test::RunUlf("sheet " + dir + " --live " + live + " --cap 60x40 -o " + picture);
  ASSERT_EQ(drawn.exit_code, 0) << drawn.errors;
  const cv::Mat sheet = cv::imread(picture);
  ASSERT_FALSE(sheet.empty());
  // Four panels of 640x480, two by two; each shows something.
  ASSERT_GT(sheet.cols, 2 * 640);
  ASSERT_GT(sheet.rows, 2 * 480);
  for (const cv::Point corner :
       {cv::Point(100, 150), cv::Point(760, 150), cv::Point(100, 680), cv::Point(760, 680)}) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(sheet(cv::Rect(corner, cv::Size(450, 300))), mean, deviation);
    EXPECT_GT(deviation[0] + deviation[1] + deviation[2], 15) << "panel at " << corner;
  }
  std::filesystem::remove(scratch / "lf/journal.jsonl");
  const auto without_journal =
      test::RunUlf("sheet " + dir + " --live " + live + " --cap 60x40 -o " + picture);
  EXPECT_EQ(without_journal.exit_code, 0) << without_journal.errors;
  const auto broken =
      test::RunUlf("sheet " + dir + " --live " + (scratch / "gone.png").string() + " -o " + picture);
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_THAT(broken.errors, testing::HasSubstr("gone.png"));
}

}  // namespace
}  // namespace ulf::contact_sheet_test
