// Tests: render/quality/nearest_view.
#include "render/quality/nearest_view.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "render/quality/quality.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::nearest_view_test {
namespace {

using Eigen::Vector3d;

TEST(NearestView, APhotographReturnsFromItsOwnPlace) {
  for (const Distortion distortion : {Distortion::kNone, Distortion::kRadialTangential}) {
    const auto scene =
        test::MakeScene({.viewpoints = test::CapViewpoints(12, 0.5, 2.0, 0.05), .distortion = distortion});
    const NearestViewRenderer renderer(*scene);
    for (std::size_t i = 0; i < scene->views.size(); ++i) {
      const SceneView& view = scene->views[i];
      const CameraModel camera = view.camera.WithoutDistortion();
      cv::Mat drawn;
      EXPECT_EQ(renderer.Draw(camera, view.cam_from_world, drawn), static_cast<int>(i));
      const cv::Mat expected = test::PhotographOfPlane(camera, view.cam_from_world);
      const cv::Rect inner(8, 8, camera.width - 16, camera.height - 16);
      const double least_db = distortion == Distortion::kNone ? 40 : 28;
      EXPECT_GT(
          CompareImages(drawn(inner), expected(inner), cv::Mat(inner.size(), CV_8U, cv::Scalar(255))).psnr_db,
          least_db)
          << i;
    }
  }
}

TEST(NearestView, ChoosesByDirectionAndNotByDistance) {
  const auto scene = test::MakeScene({.viewpoints = {{0, 0, 2}, {1, 0, 2}}});
  const NearestViewRenderer renderer(*scene);
  EXPECT_EQ(renderer.Nearest(LookAt({0.1, 0, 0.3}, Vector3d::Zero(), Vector3d::UnitY())), 1);
  EXPECT_EQ(renderer.Nearest(LookAt({0.3, 0, 9}, Vector3d::Zero(), Vector3d::UnitY())), 0);
}

TEST(NearestView, NeedsAView) { EXPECT_THROW(NearestViewRenderer(RenderScene{}), Error); }

}  // namespace
}  // namespace ulf::nearest_view_test
