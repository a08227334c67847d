// Tests: commands/rendering/review_command.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::review_command_test {
namespace {

using ::testing::HasSubstr;

class ReviewCommand : public testing::Test {
 protected:
  void SetUp() override {
    WriteLightField(scratch_ / "lf", {.viewpoints = GridViewpoints(4, 3, 0.2, 2.0)}, true);
  }
  CommandResult Review(const std::string& options) const {
    return RunUlf("review " + (scratch_ / "lf").string() +
                  " 'sim:board?board=charuco:5x5:36:27:DICT_APRILTAG_36h11&stops=3' --width 160 --height 120 "
                  "--frames 6 --json " +
                  options);
  }
  ScratchFolder scratch_;
};

TEST_F(ReviewCommand, AMarkerMovesTheLightField) {
  const std::string out = (scratch_ / "pictures").string();
  const auto run = Review("--markers charuco:5x5:36:27:DICT_APRILTAG_36h11 -o " + out);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output);
  EXPECT_EQ(report["frames"], 6);
  EXPECT_GT(report["with_marker"], 0);
  EXPECT_GT(report["views_shown"], 0);
  const cv::Mat last = cv::imread(out + "/frame_00005.png");
  ASSERT_EQ(last.size(), cv::Size(160, 120));
  EXPECT_GT(cv::mean(last)[1], 5) << "it shows something";
}

TEST_F(ReviewCommand, AMarkerThatIsNeverSeenIsAFailure) {
  const auto run = Review("--markers marker:80:DICT_4X4_50:7 -o " + (scratch_ / "pictures").string());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("was never seen"));
}

TEST_F(ReviewCommand, AMarkerThatDoesNotExistIsWrongUsage) {
  const auto run = Review("--markers marker:80 -o " + (scratch_ / "pictures").string());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("marker:80"));
}

}  // namespace
}  // namespace ulf::test::review_command_test
