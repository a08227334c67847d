// Tests: tracking/refine/obstructed_views, tracking/refine/pose_check, commands/reports/check_reports.
#include "tracking/refine/obstructed_views.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "tests/support/drawn_hand.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/pose_check.h"

namespace ulf::test::obstructed_views_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<int> Obstructed(const RoomViews& views) {
  std::vector<int> found;
  for (const tracking::ObstructedView& each : CheckPoses(views.input).obstructed) found.push_back(each.view);
  return found;
}

// Seeds of even numbers: those of odd numbers settled the thresholds.
TEST(ObstructedViews, NamesAViewThroughAHand) {
  struct {
    double share;
    HandLook look;
    unsigned seed;
    int view;
  } const hands[] = {{0.2, HandLook::kSkin, 2, 4},
                     {0.45, HandLook::kTextured, 4, 0},
                     {0.7, HandLook::kPlain, 6, 9},
                     {0.9, HandLook::kTextured, 8, 5}};
  for (const auto& [share, look, seed, view] : hands) {
    const auto views = MakeViews(10, 0, 0, seed);
    DrawHand(views->images[static_cast<std::size_t>(view)].pixels, share, look, seed);
    const PoseCheck check = CheckPoses(views->input);
    ASSERT_EQ(check.obstructed.size(), 1u) << share << ", seed " << seed;
    EXPECT_EQ(check.obstructed[0].view, view) << share << ", seed " << seed;
    EXPECT_GT(check.obstructed[0].without_share, 0.3 * share)
        << "seed " << seed;  // less where little is seen
    EXPECT_LT(check.obstructed[0].without_share, share + 0.1) << "seed " << seed;
    EXPECT_GT(check.obstructed[0].agreeing_share, 0.4 * (1 - share)) << "seed " << seed;
    EXPECT_THAT(check.contradicted, IsEmpty());
  }
}

TEST(ObstructedViews, NamesNoneWhereNothingStoodBefore) {
  const Way ways[] = {Way::kHand, Way::kSideways};
  for (const Way way : ways)  // also at the rim of the set
    EXPECT_THAT(Obstructed(*MakeViews(8, 0.002, 0.05, 2, way)), IsEmpty());
  EXPECT_THAT(Obstructed(*MakeViews(3, 0, 0, 4)), IsEmpty()) << "few neighbours";
  const auto little = MakeViews(8, 0, 0, 6);
  for (Image& image : little->images) {
    cv::GaussianBlur(image.pixels, image.pixels, {}, 3);
    image.pixels.convertTo(image.pixels, -1, 0.2, 100);
  }
  EXPECT_THAT(Obstructed(*little), IsEmpty()) << "little texture";
  const auto blurred = MakeViews(8, 0, 0, 6);
  cv::Mat& pixels = blurred->images[3].pixels;
  cv::blur(pixels, pixels, {15, 1});
  EXPECT_THAT(Obstructed(*blurred), IsEmpty()) << "a shaken view";
}

// A shadow and another exposure leave the surface what it is.
TEST(ObstructedViews, AShadowIsNoHand) {
  const auto views = MakeViews(8, 0, 0, 4);
  cv::Mat& pixels = views->images[4].pixels;
  cv::Mat shadow = pixels(cv::Rect(0, 0, pixels.cols / 2, pixels.rows));
  shadow.convertTo(shadow, -1, 0.4, 5);
  EXPECT_THAT(Obstructed(*views), IsEmpty());
}

TEST(ObstructedViews, AMaskedHandIsNotNamed) {
  const auto views = MakeViews(8, 0, 0, 4);
  const cv::Mat hand = DrawHand(views->images[4].pixels, 0.4, HandLook::kTextured, 4);
  EXPECT_THAT(Obstructed(*views), ElementsAre(4));
  views->input.read_mask = [&](int view) { return view == 4 ? cv::Mat(hand == 0) : cv::Mat(); };
  EXPECT_THAT(Obstructed(*views), IsEmpty());
}

TEST(ObstructedViews, InfoNamesThemAndRepeatsIt) {
  const auto views = MakeViews(7, 0, 0, 8);
  DrawHand(views->images[3].pixels, 0.5, HandLook::kSkin, 8);
  const ScratchFolder scratch;
  const std::string dir = (scratch / "room").string();
  WriteRoom(*views, dir);
  const CommandResult told = RunUlf("info " + dir + " --check-poses");
  EXPECT_EQ(told.exit_code, 0) << told.errors;
  EXPECT_THAT(told.output, AllOf(HasSubstr("obstructed     images/000004.png: "), HasSubstr("take-back")));
  EXPECT_THAT(told.output, Not(HasSubstr("obstructed     images/000003.png")));
  EXPECT_THAT(RunUlf("info " + dir + " --check-poses --json").output,
              HasSubstr(R"("obstructed":[{"agreeing_share":)"));
  const CommandResult plain = RunUlf("info " + dir);
  EXPECT_THAT(plain.errors, HasSubstr("of the picture of view 4 (images/000004.png)"));
}

}  // namespace
}  // namespace ulf::test::obstructed_views_test
