// Tests: tracking/refine/view_rows.
#include "tracking/refine/view_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/rolling_light_field.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::test::view_rows_test {
namespace {

const CameraModel kLens{
    320, 240, 260, 261, 158.7, 122.1, Distortion::kRadialTangential, {-0.12, 0.03, 0.0006, -0.0004, 0}};

// The largest distance in pixels at which two poses show points of the wall.
double ApartPx(const CameraModel& camera, const Rigid3& a, const Rigid3& b) {
  double most = 0;
  for (const double x : {-0.8, 0.0, 0.8})
    for (const double y : {-0.6, 0.0, 0.6}) {
      const auto in_a = camera.ImgFromCam(a * Eigen::Vector3d(x, y, kWallDistance)),
                 in_b = camera.ImgFromCam(b * Eigen::Vector3d(x, y, kWallDistance));
      most = std::max(most, (*in_a - *in_b).norm());
    }
  return most;
}

TEST(ViewRows, EachRowHasItsTruePose) {
  for (const double readout_s : {0.03, -0.02}) {
    const RollingLightField rolling = MakeRollingLightField(kLens, readout_s, 0.6, 0.4);
    const std::map<int, ViewRows> rows = RowsOfViews(rolling.light_field);
    ASSERT_EQ(rows.size(), rolling.light_field.views.size());
    double pictures_apart_px = 0;
    for (std::size_t v = 0; v < rows.size(); ++v) {
      const View& view = rolling.light_field.views[v];
      const ViewRows& of_view = rows.at(view.id);
      pictures_apart_px =
          std::max(pictures_apart_px, ApartPx(kLens, view.cam_from_world, rolling.middle_rows[v]));
      EXPECT_LT(ApartPx(kLens, of_view.middle_from_world, rolling.middle_rows[v]), 0.1);
      for (const double row : {0.0, 60.0, 240.0}) {
        const double time_s = readout_s * (row / 240 - 0.5);
        const Rigid3 truth = Perturbed(rolling.middle_rows[v], time_s * rolling.twists[v]);
        EXPECT_LT(ApartPx(kLens, of_view.PoseAt(kLens, row), truth), 0.1) << view.id << ", row " << row;
      }
    }
    EXPECT_GT(pictures_apart_px, 0.5) << "the picture's pose is not the middle row's";
  }
}

TEST(ViewRows, OnlyMovingViewsWithPointsHaveRows) {
  RollingLightField rolling = MakeRollingLightField(kLens, 0.03, 0.6, 0.4);
  LightField& light_field = rolling.light_field;
  light_field.views[1].twist.reset();
  for (ScenePoint& point : light_field.points)
    std::erase_if(point.track, [](const ViewObservation& seen) { return seen.view_id == 3; });
  const std::map<int, ViewRows> rows = RowsOfViews(light_field);
  EXPECT_EQ(rows.size(), light_field.views.size() - 2);
  EXPECT_FALSE(rows.contains(2) || rows.contains(3));
  light_field.readout = ShutterReadout{0, {}};
  EXPECT_TRUE(RowsOfViews(light_field).empty());
  light_field.readout.reset();
  EXPECT_TRUE(RowsOfViews(light_field).empty());
}

double Psnr(const cv::Mat& a, const cv::Mat& b, const cv::Mat& valid) {
  const double error = cv::norm(a, b, cv::NORM_L2, valid);
  return 10 * std::log10(255.0 * 255.0 * cv::countNonZero(valid) / (error * error));
}

// Against the wall as a global shutter takes it from the middle row's place.
TEST(ViewRows, OneInstantShowsWhatAGlobalShutterSees) {
  const CameraModel camera = CameraModel::Pinhole(320, 240, 260);
  const ScratchFolder scratch;
  const RollingLightField rolling = MakeRollingLightField(camera, 0.03, 0.6, 0.4, scratch / "lf");
  const std::map<int, ViewRows> rows = RowsOfViews(rolling.light_field);
  const TexturedRoom wall = PlainWall();
  for (const View& view : rolling.light_field.views) {
    const ViewRows& of_view = rows.at(view.id);
    const cv::Mat taken =
        cv::imread((rolling.light_field.root / view.image_path).string(), cv::IMREAD_GRAYSCALE);
    const cv::Mat truth = wall.Take(of_view.middle_from_world, 0, camera).image.pixels,
                  picture = wall.Take(view.cam_from_world, 0, camera).image.pixels;
    const UndistortionMap known = InstantMap(of_view, camera, camera,
                                             DepthOfWall(camera, of_view.middle_from_world)),
                          of_points = InstantMap(of_view, camera, camera, cv::Mat::zeros(240, 320, CV_32F));
    cv::Mat inside(truth.size(), CV_8U, cv::Scalar(0));
    inside(cv::Rect(20, 20, 280, 200)) = 255;
    const double before = Psnr(taken, picture, inside);
    EXPECT_GT(Psnr(Undistorted(known, taken), truth, inside), before + 8) << view.id;
    EXPECT_GT(Psnr(Undistorted(of_points, taken), truth, inside), before + 8)
        << view.id << ", depths of points";
  }
}

TEST(ViewRows, ObservationsMoveWithTheInstant) {
  const RollingLightField rolling = MakeRollingLightField(kLens, 0.03, 0.6, 0.4);
  const LightField instant = AtOneInstant(rolling.light_field, RowsOfViews(rolling.light_field));
  EXPECT_FALSE(instant.readout);
  double moved_px = 0;
  for (std::size_t i = 0; i < instant.points.size(); ++i)
    for (std::size_t k = 0; k < instant.points[i].track.size(); ++k) {
      const ViewObservation& seen = instant.points[i].track[k];
      const View& view = *instant.FindView(seen.view_id);
      EXPECT_FALSE(view.twist);
      const auto expected = kLens.ImgFromCam(view.cam_from_world * instant.points[i].position_in_world);
      EXPECT_LT((*expected - seen.in_img).norm(), 0.1);
      moved_px = std::max(moved_px, (rolling.light_field.points[i].track[k].in_img - seen.in_img).norm());
    }
  EXPECT_GT(moved_px, 2);
}

}  // namespace
}  // namespace ulf::test::view_rows_test
