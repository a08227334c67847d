// Tests: coverage/operator/coverage_drawing, coverage/operator/shown_sphere.
#include "coverage/operator/coverage_drawing.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "core/geometry/angles.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/measured/error_map.h"
#include "coverage/operator/shown_sphere.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"

namespace ulf::test::coverage_drawing_test {
namespace {

// How many pixels have a colour of their own: paint does, the ground does not.
double Coloured(const cv::Mat& picture) {
  int count = 0;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const cv::Vec3b& bgr = picture.at<cv::Vec3b>(y, x);
      count += std::max({bgr[0], bgr[1], bgr[2]}) - std::min({bgr[0], bgr[1], bgr[2]}) > 60;
    }
  return count / static_cast<double>(picture.total());
}

TEST(CoverageDrawing, TheChartIsPaintedAsFarAsTheMapIs) {
  StagedCapture capture;
  const auto few = capture.Record(capture.CameraAt(0, 0))->coverage;
  capture.RecordRows(-12, 12, -6, 6, 2);
  const auto many = capture.recorded().back()->coverage;
  ASSERT_GT(many->CoveredShare(), 4 * few->CoveredShare());
  const double legend = Coloured(DrawCoverageMap(*few));
  EXPECT_GT(Coloured(DrawCoverageMap(*many)), legend + 0.03);
  EXPECT_EQ(DrawCoverageMap(CoverageMap(capture.subject(), {}), {.width = 400}).size(), cv::Size(400, 200))
      << "before the first view";
}

// What is dark inside the cap is what the map counts as open, and as much of it.
TEST(CoverageDrawing, ShowsOpenDirectionsAsTheMapCounts) {
  StagedCapture capture;
  capture.Record(capture.CameraAt(0, 0));
  capture.RecordRows(-12, 4, -6, 6, 4);
  const auto map = capture.recorded().back()->coverage;
  ASSERT_TRUE(map->options().cap);
  ASSERT_GT(map->Holes().size(), 0u);
  const cv::Mat chart = DrawCoverageMap(*map);
  const cv::Mat right = chart.colRange(chart.cols - 3, chart.cols);
  EXPECT_EQ(cv::norm(right, cv::Mat(right.size(), CV_8UC3, cv::Scalar::all(250)), cv::NORM_INF), 0)
      << "no words are cut";
  const auto count = [&](const cv::Vec3b& color) {
    cv::Mat same;
    cv::inRange(chart, color, color, same);
    return static_cast<double>(cv::countNonZero(same));
  };
  const double dark = count({92, 92, 92}), painted = Coloured(chart) * static_cast<double>(chart.total());
  EXPECT_NEAR(dark / (dark + painted), 1 - map->CoveredShare(), 0.03);
  // The largest holes have their numbers beside them, each on a white disc.
  const auto white = [](const cv::Mat& picture) {
    cv::Mat same;
    cv::inRange(picture, cv::Scalar::all(255), cv::Scalar::all(255), same);
    return cv::countNonZero(same);
  };
  const int numbered = static_cast<int>(std::min<std::size_t>(3, map->Holes().size()));
  EXPECT_GT(white(chart), numbered * 150);
  EXPECT_LT(white(chart), numbered * 260);
  // A line below the legend lists the holes; where there are none there is no such line.
  StagedCapture whole({.threshold_px = 24});  // discs of seven degrees
  whole.Record(whole.CameraAt(0, 0));
  whole.RecordRows(-32, 32, -24, 24, 8);
  const auto covered = whole.recorded().back()->coverage;
  ASSERT_EQ(covered->Holes().size(), 0u);
  EXPECT_LT(DrawCoverageMap(*covered).rows, chart.rows);
  EXPECT_EQ(white(DrawCoverageMap(*covered)), 0);
}

TEST(CoverageDrawing, TheChartOfErrorsIsPaintedByThem) {
  StagedCapture capture;
  capture.RecordRows(-12, 12, -6, 6, 2);
  const auto map = capture.recorded().back()->coverage;
  constexpr double kGoal_db = 33;
  const auto errors_of = [&](double db, render::ErrorCause cause) {
    ErrorMap errors;
    for (int azimuth = -10; azimuth <= 10; azimuth += 2) {
      MeasuredFrame frame;
      frame.direction = map->frame()->Direction(Radians(azimuth), 0);
      frame.nearest_view_angle = Radians(2);
      frame.measurable = true;
      frame.db = db;
      frame.cause = cause;
      errors.Add(frame);
    }
    return errors;
  };
  const cv::Mat nothing = DrawErrorMap(*map, {}, kGoal_db);
  const cv::Mat good = DrawErrorMap(*map, errors_of(45, render::ErrorCause::kNone), kGoal_db);
  const cv::Mat bad = DrawErrorMap(*map, errors_of(20, render::ErrorCause::kSurface), kGoal_db);
  EXPECT_GT(Coloured(good), Coloured(nothing) + 0.002);
  EXPECT_GT(bad.rows, good.rows) << "a line says what is wrong";
  const auto redness = [](const cv::Mat& picture) {
    const cv::Scalar mean = cv::mean(picture);
    return mean[2] - mean[0];
  };
  EXPECT_GT(redness(bad), redness(nothing) + 0.5);
  EXPECT_LT(redness(good), redness(nothing) - 0.5);
}

TEST(CoverageDrawing, FramesTheSubjectInWhiteOrRed) {
  StagedCapture capture;
  const auto state = capture.Record(capture.CameraAt(0, 0));
  const cv::Mat grey(capture.camera().height, capture.camera().width, CV_8UC3, cv::Scalar::all(90));
  const auto corner_of_rectangle = [&](const Rigid3& cam_from_world) {
    const cv::Mat drawn = DrawOverlay(grey, capture.camera(), cam_from_world, *state->coverage);
    return drawn.at<cv::Vec3b>(static_cast<int>(0.5 * (1 - kRectangleShare) * grey.rows),
                               static_cast<int>(0.5 * grey.cols));
  };
  const double aside = 0.35 * capture.camera().width / capture.camera().fx;
  const cv::Vec3b held = corner_of_rectangle(capture.CameraAt(0, 0)),
                  left = corner_of_rectangle(capture.CameraAt(0, 0, 1, {aside, 0}));
  EXPECT_GT(std::min({held[0], held[1], held[2]}), 200) << held;
  EXPECT_GT(left[2], left[0] + 80) << left;
}

// Whoever looks at the picture does not know what lies behind the limb.
TEST(ShownSphere, ExcludesTheFarSide) {
  StagedCapture capture;
  for (const double azimuth : {0.0, 40.0, 150.0}) capture.Record(capture.CameraAt(azimuth, 0));
  const auto state = capture.At(capture.CameraAt(0, 0));
  state->guidance.toward = state->coverage->frame()->Direction(150 * M_PI / 180, 0);
  const auto shown = ShownSphere::Of(*state);
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->views.size(), 2u);
  EXPECT_NEAR(shown->AngleFromDot(shown->views[0].direction), 0, 1e-6);
  EXPECT_NEAR(shown->AngleFromDot(shown->views[1].direction), 40 * M_PI / 180, 1e-6);
  ASSERT_TRUE(shown->target);
  EXPECT_TRUE(shown->target->hidden);
  EXPECT_NEAR(std::cos(shown->AngleFromDot(shown->target->direction)), shown->least_cosine, 1e-9)
      << "at the limb";
  state->cam_from_world.reset();
  EXPECT_FALSE(ShownSphere::Of(*state));
}

}  // namespace
}  // namespace ulf::test::coverage_drawing_test
