// Tests: render/stereo/bracket_merge, core/light_field/light_field.
#include "render/stereo/bracket_merge.h"

#include <gmock/gmock.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/light_field/light_field.h"
#include "tests/render/scenes/bracketed_view.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::bracket_merge_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const BracketedView kView;
constexpr int kPoints = 6000;

double MedianError(const cv::Mat& light, const cv::Mat& truth) {
  std::vector<float> errors;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const float is = light.at<cv::Vec3f>(y, x)[1], should = truth.at<cv::Vec3f>(y, x)[1];
      if (should > 0) errors.push_back(std::abs(is / should - 1));
    }
  std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2));
  return errors[errors.size() / 2];
}

// Pixels beyond full scale of the view's own exposure, by their share within a tenth of the truth.
double ShareOfHighlightsRight(const cv::Mat& light, const cv::Mat& truth) {
  int right = 0, all = 0;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const float is = light.at<cv::Vec3f>(y, x)[1], should = truth.at<cv::Vec3f>(y, x)[1];
      if (should < 1.2) continue;
      ++all;
      right += std::abs(is / should - 1) < 0.1;
    }
  return all > 0 ? right / static_cast<double>(all) : 0;
}

TEST(BracketMerge, AlignsHandheldExposuresByGeometry) {
  const ScratchFolder scratch;
  const SimulatedCamera camera = LightboxCamera(kView);
  const LightField light_field = TakeBracket(camera, kView, scratch / "lf", {-2, 2, -4, 4});
  const View& view = light_field.views.at(0);
  const cv::Mat truth = camera.CleanLinear(view.cam_from_world);
  const auto geometry = PointsSeen(camera, view.cam_from_world, kPoints);
  const MergedView aligned = MergeExposuresOf(light_field, view, *geometry);
  const MergedView lying = MergeExposuresOf(light_field, view, *geometry, {.align = false});
  View alone = view;
  alone.exposures.clear();
  const MergedView single = MergeExposuresOf(light_field, alone, *geometry);
  EXPECT_EQ(aligned.exposures, 5);
  EXPECT_THAT(aligned.left_out, IsEmpty());
  EXPECT_NEAR(aligned.longest / aligned.shortest, 256, 12);
  const double of_aligned = MedianError(aligned.merged.light, truth),
               of_lying = MedianError(lying.merged.light, truth),
               of_single = MedianError(single.merged.light, truth);
  EXPECT_LT(of_aligned, 0.6 * of_lying);
  EXPECT_LT(of_aligned, 0.8 * of_single);
  EXPECT_LT(aligned.merged.ghost_share, 0.02) << "nothing moves in the scene";
  EXPECT_GT(lying.merged.ghost_share, 0.2);
  // The longest exposure lasts 16 ms.
  EXPECT_NEAR(aligned.most_blur_px, camera.BlurPx(kView.at_s + 4 * kView.between_s, 0.016), 0.4);
  EXPECT_GT(ShareOfHighlightsRight(aligned.merged.light, truth), 0.6);
  EXPECT_LT(ShareOfHighlightsRight(single.merged.light, truth), 0.1) << "clipped";
}

double MedianOf(std::vector<double> all) {
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2));
  return all[all.size() / 2];
}

// Also just below full scale, beside pixels that are full and where another colour is: there the view's own
// exposure is the least noisy one.
TEST(BracketMerge, IsNeverWorseThanTheViewsExposure) {
  ErrorsByStop merged, own;
  for (const unsigned seed : {7u, 8u}) {
    const BracketedView how{.seed = seed, .width = 360, .height = 270, .between_s = 0.05};
    const ScratchFolder scratch;
    const SimulatedCamera camera = LightboxCamera(how);
    const LightField light_field = TakeBracket(camera, how, scratch / "lf", {-2, 2});
    const View& view = light_field.views.at(0);
    const auto geometry = PointsSeen(camera, view.cam_from_world, kPoints);
    AddErrors(MergeExposuresOf(light_field, view, *geometry).merged.light,
              camera.CleanLinear(view.cam_from_world), merged);
    AddErrorsAlone(camera, light_field, view, 0, own);
  }
  constexpr std::size_t kFew = 300;  // pixels
  int compared = 0;
  for (const auto& [stop, errors] : merged) {
    if (errors.size() < kFew) continue;
    ++compared;
    EXPECT_LT(MedianOf(errors), 1.05 * MedianOf(own[stop])) << "from " << stop << " stops over full scale";
  }
  EXPECT_GT(compared, 8);
}

// A shutter that did not do what it says.
TEST(BracketMerge, LeavesOutAnInconsistentExposure) {
  const ScratchFolder scratch;
  const SimulatedCamera camera = LightboxCamera(kView);
  LightField light_field = TakeBracket(camera, kView, scratch / "lf", {-2, 2});
  const auto geometry = PointsSeen(camera, light_field.views[0].cam_from_world, kPoints);
  light_field.views[0].exposures[1].exposure_s *= 2;
  const MergedView merged = MergeExposuresOf(light_field, light_field.views[0], *geometry);
  EXPECT_EQ(merged.exposures, 2);
  ASSERT_EQ(merged.left_out.size(), 1u);
  EXPECT_THAT(merged.left_out[0], HasSubstr("0.5"));
  // A little is measured: nothing is lost by it.
  light_field.views[0].exposures[1].exposure_s *= 0.5 * 1.1;
  EXPECT_EQ(MergeExposuresOf(light_field, light_field.views[0], *geometry).exposures, 3);
  EXPECT_NEAR(MergeExposuresOf(light_field, light_field.views[0], *geometry).longest, 4, 0.08);
  light_field.views[0].exposure_s = 0;
  EXPECT_THROW(MergeExposuresOf(light_field, light_field.views[0], *geometry), Refusal);
}

TEST(BracketMerge, TheFileHoldsLightAndWhereItIsNotSure) {
  const ScratchFolder scratch;
  const SimulatedCamera camera = LightboxCamera(kView);
  const LightField light_field = TakeBracket(camera, kView, scratch / "lf", {-2, 2});
  const View& view = light_field.views.at(0);
  const MergedView merged = MergeExposuresOf(light_field, view, *ProxyForBrackets(light_field));
  const std::string file = scratch / "merged.exr";
  WriteFileAtomically(file, MergedExr(view, merged));
  cv::Mat difference;
  cv::absdiff(ReadExr(file), merged.merged.light, difference);
  EXPECT_EQ(cv::norm(difference, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(ReadExrChannel(file, kGhostsChannel)), cv::countNonZero(merged.merged.ghosts));
  EXPECT_EQ(cv::countNonZero(ReadExrChannel(file, kClippedChannel)), cv::countNonZero(merged.merged.clipped));
  EXPECT_TRUE(ReadExrChannel(file, "Z").empty());
  View linear = view, encoded = view;
  linear.master_transfer = Transfer::kLinear;
  encoded.master_transfer.reset();
  WriteFileAtomically(file, MergedExr(encoded, merged));
  EXPECT_EQ(ExrColorsOf(file), ExrColors(kRec709));
  WriteFileAtomically(file, MergedExr(linear, merged));
  EXPECT_FALSE(ExrColorsOf(file)) << "the sensor's own";
  EXPECT_THAT(ExrAttribute(file, "ulfExposures"), HasSubstr("3 from 0.25 to 4"));
}

}  // namespace
}  // namespace ulf::test::bracket_merge_test
