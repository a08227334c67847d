// Tests: render/stereo/semi_global, render/stereo/stereo_view, render/stereo/plane_sweep.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "render/stereo/plane_sweep.h"
#include "render/stereo/semi_global.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf::stereo_parts_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A volume whose cost grows with the distance from `label` at each pixel.
CostVolume VolumeAround(int width, int height, int labels, const std::function<double(int x, int y)>& label) {
  CostVolume volume(width, height, labels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int l = 0; l < labels; ++l)
        volume.At(x, y)[l] = static_cast<std::uint8_t>(std::min(60.0, 6 * std::pow(l - label(x, y), 2)));
  return volume;
}

TEST(SemiGlobal, InterpolatesBetweenLabels) {
  const CostVolume volume = VolumeAround(12, 9, 20, [](int, int) { return 7.3; });
  const cv::Mat labels = SemiGlobalMinimum(volume, cv::Mat(9, 12, CV_32F, cv::Scalar(100)), {});
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 12; ++x) EXPECT_NEAR(labels.at<float>(y, x), 7.3, 0.1);
}

TEST(SemiGlobal, APixelThatContradictsAllAroundGivesWay) {
  const auto wrong_in_the_middle = [](int x, int y) { return x == 6 && y == 4 ? 15.0 : 5.0; };
  const cv::Mat flat(9, 12, CV_32F, cv::Scalar(100));
  const CostVolume volume = VolumeAround(12, 9, 20, wrong_in_the_middle);
  EXPECT_NEAR(SemiGlobalMinimum(volume, flat, {}).at<float>(4, 6), 5, 1);
  EXPECT_NEAR(SemiGlobalMinimum(volume, flat, {.small_step = 0, .large_step = 0}).at<float>(4, 6), 15, 0.6)
      << "where changes cost nothing it stays";
}

TEST(SemiGlobal, AStepOfDepthStaysAtAnEdgeOfBrightness) {
  const CostVolume volume = VolumeAround(20, 9, 20, [](int x, int) { return x < 10 ? 4.0 : 14.0; });
  cv::Mat grey(9, 20, CV_32F, cv::Scalar(50));
  grey.colRange(10, 20) = cv::Scalar(200);
  const cv::Mat labels = SemiGlobalMinimum(volume, grey, {});
  for (int x = 0; x < 20; ++x) EXPECT_NEAR(labels.at<float>(4, x), x < 10 ? 4 : 14, 0.5) << x;
}

TEST(StereoView, IsThePhotographInGreyAtTheWorkingSize) {
  for (const Distortion distortion : {Distortion::kNone, Distortion::kFisheye}) {
    const auto scene = test::MakeScene(
        {.viewpoints = {{0.2, 0.1, 2}}, .width = 120, .height = 90, .distortion = distortion});
    const StereoView view = MakeStereoView(scene->views[0], 60);
    EXPECT_EQ(view.camera.width, 60);
    EXPECT_EQ(view.camera.distortion, Distortion::kNone);
    EXPECT_TRUE(view.valid.empty());
    // The texture of the plane where the pixels' rays meet it.
    double error = 0;
    for (int y = 5; y < 40; ++y)
      for (int x = 5; x < 55; ++x) {
        const Vector3d ray = view.RayInWorld(x, y);
        const Vector3d point = view.center_in_world - view.center_in_world.z() / ray.z() * ray;
        EXPECT_LT((*view.Project(point) - Vector2d(x + 0.5, y + 0.5)).norm(), 1e-6);
        const cv::Vec3f light = test::PlaneTexture(point.x(), point.y());
        const auto level = [&](int c) { return 255 * SrgbFromLinear(light[c]); };
        error +=
            std::abs(view.grey.at<float>(y, x) - (0.114f * level(0) + 0.587f * level(1) + 0.299f * level(2)));
      }
    EXPECT_LT(error / (35 * 50), 8) << "mean of the levels";
  }
}

TEST(StereoView, PixelsWithoutLightAreNotValid) {
  const auto scene =
      test::MakeScene({.viewpoints = {{0, 0, 2}}, .linear_with_gaps = true});  // a hole in the middle
  const StereoView view = MakeStereoView(scene->views[0], 96);
  ASSERT_FALSE(view.valid.empty());
  EXPECT_EQ(view.valid.at<std::uint8_t>(36, 48), 0);
  EXPECT_NE(view.valid.at<std::uint8_t>(4, 4), 0);
}

TEST(PlaneCarrier, TakesPixelsByWayOfAPlane) {
  const auto view = test::Draw({}, {0, 0, 0}, {0, 0, 3}).view;
  const auto neighbour = test::Draw({}, {0.4, -0.1, 0.2}, {0.1, 0, 3}).view;
  const PlaneCarrier carrier = MakePlaneCarrier(view, neighbour);
  for (const double depth : {1.5, 3.0, 20.0})
    for (const auto& [x, y] : {std::pair{10, 20}, {60, 45}, {110, 70}}) {
      const Vector3d point = view.center_in_world + depth * view.RayInWorld(x, y);
      Eigen::Matrix3f map = carrier.at_infinity;
      map.col(2) += static_cast<float>(1 / depth) * carrier.per_inverse_depth;
      const Eigen::Vector3f to = map * Eigen::Vector3f(x + 0.5f, y + 0.5f, 1);
      const auto img = neighbour.camera.ImgFromCam(neighbour.cam_from_world * point);
      ASSERT_TRUE(img);
      EXPECT_LT((to.head<2>().cast<double>() / to.z() - *img).norm(), 1e-3) << depth;
    }
}

}  // namespace
}  // namespace ulf::stereo_parts_test
