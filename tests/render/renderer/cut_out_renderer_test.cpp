// Tests: render/renderer/cut_out_renderer.
#include <gtest/gtest.h>

#include "render/gl/make_renderer.h"
#include "render/output/picture_files.h"
#include "render/renderer/cut_out_renderer.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

using Eigen::Vector3d;

constexpr double kDisc = 0.3;  // of the plane z = 0: what the masks leave

// Whether a pixel's ray meets the disc; by how much it is inside.
double InsideDisc(const CameraModel& camera, const Rigid3& cam_from_world, int x, int y) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d ray = world_from_cam.rotation * *camera.RayFromImg({x + 0.5, y + 0.5});
  const Vector3d point = world_from_cam.translation - ray * (world_from_cam.translation.z() / ray.z());
  return kDisc - point.head<2>().norm();
}

cv::Mat MaskOfDisc(const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat mask(camera.height, camera.width, CV_8UC3, cv::Scalar::all(0));
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (InsideDisc(camera, cam_from_world, x, y) > 0) mask.at<cv::Vec3b>(y, x) = cv::Vec3b::all(255);
  return mask;
}

// Over the plane on which the disc lies its outline is where it is, in both renderers, and the background is gone.
TEST(CutOutRenderer, AlphaIsWhatTheMasksLeave) {
  const test::SceneSpec spec{
      .viewpoints = test::GridViewpoints(5, 5, 0.15, 2.0), .width = 160, .height = 120, .focal_px = 140};
  const auto scene = test::MakeScene(spec), masks = test::MakeScene(spec);
  for (std::size_t i = 0; i < scene->views.size(); ++i) {
    const SceneView& view = scene->views[i];
    masks->views[i].photograph =
        test::HoldPhotograph(MakePyramid(MaskOfDisc(view.camera, view.cam_from_world)));
  }
  const CameraModel camera = CameraModel::Pinhole(120, 90, 110);
  const Rigid3 pose = LookAt({0.11, 0.07, 1.95}, Vector3d::Zero(), Vector3d::UnitY());
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const RenderOptions options{.field = {.kind = FieldKind::kLinear}, .renderer = kind};
    CutOutRenderer renderer(MakeRenderer(scene, options), MakeRenderer(masks, options));
    const Rendering picture = renderer.Render(camera, pose);
    ASSERT_EQ(picture.alpha.size(), picture.linear.size()) << renderer.Name();
    const double pixel = 2.0 / 110;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const double inside = InsideDisc(camera, pose, x, y);
        if (std::abs(inside) < 2 * pixel) continue;
        ASSERT_EQ(picture.alpha.at<float>(y, x), inside > 0 ? 1 : 0)
            << renderer.Name() << " " << x << " " << y;
      }
    // As a file it is transparent, or lies over a colour.
    const auto decoded = [&](const PictureEncoding& encoding) {
      const std::string png = PictureBytes(picture, encoding);
      return cv::imdecode(std::vector<char>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);
    };
    const cv::Mat clear = decoded({});
    ASSERT_EQ(clear.type(), CV_8UC4);
    EXPECT_EQ(clear.at<cv::Vec4b>(2, 2), cv::Vec4b(0, 0, 0, 0));
    EXPECT_EQ(clear.at<cv::Vec4b>(45, 60)[3], 255);
    const cv::Mat over = decoded({.background = cv::Vec3d(1, 0.5, 0)});
    ASSERT_EQ(over.type(), CV_8UC3);
    EXPECT_LE(cv::norm(over.at<cv::Vec3b>(2, 2), cv::Vec3b(255, 128, 0), cv::NORM_INF), 1);
  }
}

}  // namespace
}  // namespace ulf
