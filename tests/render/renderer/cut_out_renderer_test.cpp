// Tests: render/renderer/cut_out_renderer.
#include <gtest/gtest.h>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/output/picture_files.h"
#include "render/renderer/cut_out_renderer.h"
#include "tests/render/scenes/disc_masks.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::cut_out_renderer_test {
namespace {

using Eigen::Vector3d;

constexpr double kDisc = 0.3;  // of the plane z = 0: what the masks leave

// Over the plane on which the disc lies its outline is where it is, in both renderers, and the
// background is gone.
TEST(CutOutRenderer, AlphaIsWhatTheMasksLeave) {
  const test::SceneSpec spec{
      .viewpoints = test::GridViewpoints(5, 5, 0.15, 2.0), .width = 160, .height = 120, .focal_px = 140};
  const auto scene = test::MakeScene(spec), masks = test::DiscMasks(spec, kDisc);
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
        const double inside = test::InsideDisc(kDisc, camera, pose, x, y);
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
}  // namespace ulf::cut_out_renderer_test
