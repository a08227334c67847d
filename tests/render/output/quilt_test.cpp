// Tests: render/output/quilt.
//
// Quilts for light-field displays: one window for all tiles, no toe-in, in the order that displays read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/geometry/angles.h"
#include "render/fields/field_options.h"
#include "render/output/quilt.h"
#include "render/renderer/reference_renderer.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::quilt_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr QuiltFormat kSmall{4, 3, 192, 192, 0.75};

std::shared_ptr<RenderScene> SceneOfCap() {
  return test::MakeScene({.viewpoints = test::CapViewpoints(60, Radians(35), 1.5, 0.1)});
}

// Fills a picture with the number of its viewpoint in the order of being asked.
class NumberingRenderer : public Renderer {
 public:
  explicit NumberingRenderer(std::shared_ptr<const RenderScene> scene) : scene_(std::move(scene)) {}
  Rendering Render(const CameraModel& camera, const Rigid3&) override {
    Rendering rendering;
    rendering.linear =
        cv::Mat(camera.height, camera.width, CV_32FC3, cv::Scalar::all(0.05 * static_cast<double>(asked_++)));
    rendering.drawn = cv::Mat(rendering.linear.size(), CV_8U, cv::Scalar(255));
    return rendering;
  }
  void SetField(const FieldOptions&) override {}
  void SetProxy(std::shared_ptr<const Proxy>) override {}
  void SetAperture(const std::optional<Aperture>&) override {}
  FieldOptions field() const override { return {}; }
  std::string Name() const override { return "numbering"; }
  const RenderScene& scene() const override { return *scene_; }

 private:
  std::shared_ptr<const RenderScene> scene_;
  int asked_ = 0;
};

TEST(Quilt, EveryTileIsTheSameWindowFromALineBeforeIt) {
  const auto scene = SceneOfCap();
  for (const double aspect : {0.75, 0.5, 1.77778}) {
    QuiltFormat format = kSmall;
    format.aspect = aspect;
    const QuiltViews views = QuiltViewsOf(*scene, {.format = format});
    ASSERT_EQ(views.cameras.size(), 12u);
    EXPECT_NEAR(views.width / views.height, aspect, 1e-9);
    const Vector3d forward = views.up.cross(views.right);
    double before = -10;
    for (std::size_t i = 0; i < 12; ++i) {
      const CameraModel& camera = views.cameras[i];
      EXPECT_EQ(camera.width, 48);
      EXPECT_EQ(camera.height, 64);
      // The same corners of the window are the tile's corners.
      for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5}) {
          const Vector3d corner =
              views.window_center + x * views.width * views.right - y * views.height * views.up;
          const Vector2d img = *camera.ImgFromCam(views.cam_from_world[i] * corner);
          EXPECT_LT((img - Vector2d((x + 0.5) * 48, (y + 0.5) * 64)).norm(), 1e-6);
        }
      // No toe-in, and a line parallel to the window, from the left, at equal angles.
      EXPECT_LT(
          (views.cam_from_world[i].rotation.coeffs() - views.cam_from_world[0].rotation.coeffs()).norm(),
          1e-12);
      const Vector3d arm = views.cam_from_world[i].OriginInSource() - views.window_center;
      EXPECT_NEAR(arm.dot(views.up), 0, 1e-9);
      EXPECT_NEAR(-arm.dot(forward), 1.5, 0.15);
      const double angle = std::atan2(arm.dot(views.right), -arm.dot(forward));
      EXPECT_NEAR(angle, (static_cast<double>(i) / 11 - 0.5) * views.view_cone, 1e-9);
      EXPECT_GT(angle, before);
      before = angle;
    }
    // The subject's sphere fits.
    EXPECT_GE(std::min(views.width, views.height), 2 * scene->subject.radius);
  }
}

TEST(Quilt, TakesTheConeThatTheRecordedViewpointsCarry) {
  const QuiltViews of_cap = QuiltViewsOf(*SceneOfCap(), {.format = kSmall});
  EXPECT_EQ(of_cap.outside, 0);
  EXPECT_GT(Degrees(of_cap.view_cone), 45);  // a cap of 70 degrees, less at its rim
  EXPECT_LE(of_cap.view_cone, kMostViewCone + 1e-9);
  const auto narrow = test::MakeScene({.viewpoints = test::CapViewpoints(60, Radians(12), 1.5)});
  const double carried = Degrees(QuiltViewsOf(*narrow, {.format = kSmall}).view_cone);
  EXPECT_GT(carried, 15);
  EXPECT_LT(carried, 24);
  EXPECT_GT(QuiltViewsOf(*narrow, {.format = kSmall, .view_cone = Radians(50)}).outside, 2);
  const auto ring = test::MakeScene({.viewpoints = test::RingViewpoints(40, Radians(20), 1.5)});
  EXPECT_NEAR(QuiltViewsOf(*ring, {.format = kSmall}).view_cone, kMostViewCone, Radians(1.1));
}

TEST(Quilt, TilesBeginAtTheBottomLeft) {
  const auto scene = SceneOfCap();
  NumberingRenderer renderer(scene);
  int last = 0;
  const QuiltViews views = QuiltViewsOf(*scene, {.format = kSmall});
  const cv::Mat quilt = DrawQuilt(renderer, views, kSmall, [&](int done) { last = done; });
  EXPECT_EQ(last, 12);
  ASSERT_EQ(quilt.size(), cv::Size(192, 192));
  for (int i = 0; i < 12; ++i) {
    const cv::Mat linear(1, 1, CV_32FC3, cv::Scalar::all(0.05 * i));
    const auto expected = Srgb8FromLinear(linear).at<cv::Vec3b>(0, 0);
    const int left = i % 4 * 48, top = 192 - (i / 4 + 1) * 64;
    EXPECT_EQ(quilt.at<cv::Vec3b>(top + 1, left + 1), expected) << i;
    EXPECT_EQ(quilt.at<cv::Vec3b>(top + 62, left + 46), expected) << i;
  }
}

// What lies in the window does not move from tile to tile; what stands before it does, against the viewpoint.
TEST(Quilt, WindowPlaneHasNoParallax) {
  // The square is a small part of what the subject's sphere holds.
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(9, 5, 0.15, 1.5),
                                      .subject = {Vector3d::Zero(), 0.6},
                                      .with_square = true});
  const auto over_mesh =
      WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, test::PlaneAndSquare()));
  ReferenceRenderer renderer(over_mesh, {});
  const QuiltFormat format{3, 1, 3 * 96, 96, 1};
  const QuiltViews views = QuiltViewsOf(*over_mesh, {.format = format, .view_cone = Radians(24)});
  const cv::Mat quilt = DrawQuilt(renderer, views, format);
  // The rows below and above the square show the plane alone, which is the window.
  const cv::Mat left = quilt({0, 0, 96, 20}), right = quilt({192, 0, 96, 20});
  EXPECT_GT(cv::PSNR(left, right), 27);
  // The square's edges, predicted by similar triangles.
  const double z = test::kSquareZ;
  const double distance = (views.cam_from_world[1].OriginInSource() - views.window_center).norm();
  const double shift = distance * std::tan(Radians(12)) * z / (distance - z);
  const double in_tile = shift * 96 / views.width;
  EXPECT_GT(in_tile, 5);
  const cv::Mat middle_row = quilt({96 + 24, 44, 48, 8});
  double best = 0;
  int best_shift = 0;
  for (int by = -20; by <= 20; ++by)
    if (const double psnr = cv::PSNR(middle_row, quilt({24 + by, 44, 48, 8})); psnr > best) {
      best = psnr;
      best_shift = by;
    }
  EXPECT_NEAR(best_shift, in_tile, 2);  // from the left it stands farther to the right
}

TEST(Quilt, TheWindowStandsWhereTheSubjectIsSeen) {
  const auto scene = SceneOfCap();
  for (const float before : {-0.2f, 0.1f, 0.2f}) {
    TriangleMesh plane = *test::PlaneAndSquare();
    plane.triangles.resize(2);  // without the square
    for (Eigen::Vector3f& vertex : plane.vertices) vertex.z() += before;
    const auto over_mesh =
        WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, std::make_shared<TriangleMesh>(plane)));
    const QuiltViews views = QuiltViewsOf(*over_mesh, {.format = kSmall});
    EXPECT_NEAR(views.window_center.z(), static_cast<double>(before), 0.02);
    const Vector3d arm = views.cam_from_world[0].OriginInSource() - scene->subject.center_in_world;
    EXPECT_NEAR(arm.dot(views.right.cross(views.up)), 1.5, 0.15);  // the line stays where it is
    EXPECT_EQ(views.outside, 0);
  }
}

TEST(Quilt, NamesTellFormatAndDisplay) {
  EXPECT_EQ(QuiltName("vase", {8, 6, 3360, 3360, 0.75}), "vase_qs8x6a0.75.png");
  EXPECT_EQ(QuiltName("vase", QuiltOfDisplay("go")), "vase_qs11x6a0.5625.png");
  for (const NamedQuilt& known : QuiltDisplays()) {
    const int views = known.format.columns * known.format.rows;
    EXPECT_GE(views, 45) << known.display;
    EXPECT_LE(views, 100) << known.display;
  }
  EXPECT_THAT([] { QuiltOfDisplay("wall"); }, ThrowsMessage<Refusal>(HasSubstr("portrait, go")));
  EXPECT_THAT(
      [] {
        QuiltViewsOf(*SceneOfCap(), {.format = {1, 1, 100, 100, 1}});
      },
      ThrowsMessage<Refusal>(HasSubstr("at least 2 tiles")));
  EXPECT_THAT(
      [] {
        QuiltViewsOf(*SceneOfCap(), {.format = {40, 40, 100, 100, 1}});
      },
      ThrowsMessage<Refusal>(HasSubstr("size")));
}

}  // namespace
}  // namespace ulf::quilt_test
