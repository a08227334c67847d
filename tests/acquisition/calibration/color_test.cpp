// Tests: acquisition/calibration/color_chart, acquisition/calibration/color_fit,
// acquisition/simulator/simulated_chart, acquisition/simulator/bench_device, acquisition/simulator/sensor,
// core/fiducials/color_chart_patches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "acquisition/calibration/color_chart.h"
#include "acquisition/calibration/color_fit.h"
#include "acquisition/simulator/simulated_chart.h"
#include "core/base/error.h"
#include "core/image/clipped.h"
#include "core/image/color_difference.h"
#include "tests/support/floors.h"

namespace ulf::color_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

std::vector<MeasuredChart> ChartsOf(const ChartSceneOptions& options, int frames = 3) {
  std::vector<MeasuredChart> charts;
  for (int frame = 0; frame < frames; ++frame) {
    const Image image = RenderChart(options, static_cast<std::uint64_t>(frame));
    if (const auto chart = FindColorChart(image, 0, ClippedPixels(image))) charts.push_back(*chart);
  }
  return charts;
}

Matrix3d MatrixOfProfile(const ColorProfile& profile) {
  Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = profile.matrix[static_cast<std::size_t>(i)];
  return matrix;
}

// However it is turned, the patches are measured in their order.
TEST(ColorChart, IsFoundHoweverItIsHeld) {
  for (const double turn_deg : {-20.0, 5.0, 90.0, 180.0})
    for (const double tilt_deg : {0.0, 25.0}) {
      const ChartSceneOptions options{
          .height = 640, .turn_deg = turn_deg, .tilt_deg = tilt_deg, .noise = false};
      const auto charts = ChartsOf(options, 1);
      ASSERT_EQ(charts.size(), 1u) << turn_deg << " " << tilt_deg;
      const double white = LinearSrgbFromLab(ChartLab()[kFirstGrey]).maxCoeff() / options.white;
      for (int patch = 0; patch < kChartPatches; ++patch) {
        const ChartPatch& measured = charts[0].patches[static_cast<std::size_t>(patch)];
        EXPECT_TRUE(measured.usable() || measured.rgb.minCoeff() <= 0) << patch;
        const Vector3d truth = LinearSrgbFromLab(ChartLab()[static_cast<std::size_t>(patch)]) / white;
        EXPECT_LT((measured.rgb - truth.cwiseMax(0)).cwiseAbs().maxCoeff(), 0.006)
            << "patch " << patch + 1 << ", turned by " << turn_deg << ", tilted by " << tilt_deg;
      }
    }
}

TEST(ColorChart, IsNotMistakenForOtherThings) {
  cv::Mat noise(480, 640, CV_8UC3);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 255);
  EXPECT_FALSE(FindColorChart({.pixels = noise}, 0, {}));
  EXPECT_FALSE(FindColorChart({.pixels = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(120))}, 0, {}));
  EXPECT_FALSE(FindColorChart({.pixels = cv::Mat::zeros(480, 640, CV_8UC3)}, 0, {}));
  EXPECT_FALSE(FindColorChart(RenderChart({.card = true}, 0), 0, {}));
}

// The profile is what undoes the lamp and the sensor's filters, which are known.
TEST(ColorFit, FindsTheLampAndTheFilters) {
  for (const double lamp_k : {2800.0, 5000.0, 8000.0})
    for (const double crosstalk : {0.0, 0.25}) {
      const ChartSceneOptions options{.format = SensorFormat::kBayerRg12,
                                      .colors = {.lamp_k = lamp_k, .crosstalk = crosstalk}};
      const ColorFit fit = FitColorProfile(ChartsOf(options, 2));
      ASSERT_TRUE(fit.ok()) << fit.refusal;
      const Vector3d balance = options.colors.WhiteBalance();
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(fit.profile.white_balance[static_cast<std::size_t>(c)] / balance[c], 1, 0.015)
            << lamp_k << " K, " << crosstalk;
      EXPECT_LT((MatrixOfProfile(fit.profile) - options.colors.SrgbFromBalanced()).cwiseAbs().maxCoeff(),
                0.05)
          << lamp_k << " K, " << crosstalk;
      for (int row = 0; row < 3; ++row) EXPECT_NEAR(MatrixOfProfile(fit.profile).row(row).sum(), 1, 1e-12);
      EXPECT_LT(fit.Mean(&PatchDifference::profiled), 0.8) << lamp_k << " K, " << crosstalk;
      EXPECT_LT(fit.Mean(&PatchDifference::held_out), 1.0) << lamp_k << " K, " << crosstalk;
      EXPECT_EQ(fit.profile.delta_e, fit.Mean(&PatchDifference::held_out));
      EXPECT_GT(fit.Mean(&PatchDifference::as_recorded), lamp_k < 3000 ? 10 : 0);
      EXPECT_GT(fit.Mean(&PatchDifference::balanced), crosstalk > 0 ? 3 : 0);
    }
}

// Overexposed, the white patches are said to be clipped and bend nothing.
TEST(ColorFit, LeavesOutWhatIsClipped) {
  const SensorColors colors{.lamp_k = 4000, .crosstalk = 0.2};
  const auto charts = ChartsOf({.colors = colors, .white = 1.25});
  const ColorFit fit = FitColorProfile(charts);
  ASSERT_TRUE(fit.ok()) << fit.refusal;
  EXPECT_THAT(fit.clipped, testing::Contains(kFirstGrey));
  EXPECT_LT((MatrixOfProfile(fit.profile) - colors.SrgbFromBalanced()).cwiseAbs().maxCoeff(), 0.08);
  // Taken for light, they would.
  auto unaware = charts;
  for (MeasuredChart& chart : unaware)
    for (ChartPatch& patch : chart.patches) patch.clipped = false;
  EXPECT_GT(FitColorProfile(unaware).Mean(&PatchDifference::profiled),
            1.5 * fit.Mean(&PatchDifference::profiled));
  const ColorFit white = FitColorProfile(ChartsOf({.colors = colors, .white = 6}));
  EXPECT_THAT(white.refusal, testing::AnyOf(HasSubstr("expose less"), HasSubstr("no chart")))
      << "nearly all clipped";
}

TEST(ColorFit, ReflectionOnAPatchChangesLittle) {
  const SensorColors colors{.lamp_k = 4000, .crosstalk = 0.2};
  auto charts = ChartsOf({.colors = colors});
  for (MeasuredChart& chart : charts) chart.patches[7].rgb += Vector3d::Constant(0.15);
  const ColorFit fit = FitColorProfile(charts);
  ASSERT_TRUE(fit.ok());
  EXPECT_LT((MatrixOfProfile(fit.profile) - colors.SrgbFromBalanced()).cwiseAbs().maxCoeff(), 0.15);
  EXPECT_GT(std::ranges::max_element(fit.patches, {}, &PatchDifference::profiled)->profiled, 8);
  EXPECT_EQ(std::ranges::max_element(fit.patches, {}, &PatchDifference::profiled)->patch, 7);
}

TEST(ColorFit, WithoutAChartItSaysWhatToDo) {
  EXPECT_THAT(FitColorProfile({}).refusal, HasSubstr("no chart of 24 patches"));
}

TEST(GreyCard, TellsTheWhiteBalance) {
  for (const double lamp_k : {2800.0, 6504.0, 9000.0}) {
    const ChartSceneOptions options{
        .card = true, .colors = {.lamp_k = lamp_k, .crosstalk = 0.2}, .white = 0.5};
    const Image image = RenderChart(options, 1);
    const GreyCard card = BalanceOfGreyCard(image, 0, ClippedPixels(image));
    ASSERT_TRUE(card.ok()) << card.refusal;
    const Vector3d truth = options.colors.WhiteBalance();
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(card.white_balance[static_cast<std::size_t>(c)] / truth[c], 1, 0.01) << lamp_k;
  }
}

TEST(GreyCard, RefusesOtherThings) {
  const auto refusal = [](const Image& image) {
    return BalanceOfGreyCard(image, 0, ClippedPixels(image)).refusal;
  };
  EXPECT_THAT(refusal(RenderChart({.card = true, .white = 1.3}, 0)), HasSubstr("clipped"));
  EXPECT_THAT(refusal(RenderChart({.card = true, .white = 0.02}, 0)), HasSubstr("dark"));
  EXPECT_THAT(refusal(RenderChart({}, 0)), HasSubstr("uneven"));
}

}  // namespace
}  // namespace ulf::color_test
