// Tests: render/quality/nearest_view, tests/charts/plot/quality_chart.
#include "render/quality/nearest_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "render/quality/quality.h"
#include "tests/charts/plot/quality_chart.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf {
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

TEST(QualityChart, HasAPointForEachFieldAndAColourForEachProxy) {
  EvaluateSummary summary{.views = 20, .held_out = 4, .width = 64, .height = 48, .renderer = "reference"};
  FieldScore score;
  score.asked.kind = score.used.kind = FieldKind::kSubdivision;
  score.used.level = 2;
  score.proxy = "mesh";
  score.inside = {.views = 3, .psnr_db = 31.5};
  score.ms_per_frame = 12;
  summary.results.push_back(score);
  score.proxy = "plane";
  score.used.kind = FieldKind::kLumigraph;
  summary.results.push_back(score);
  const Chart chart = QualityChart(summary, "vase");
  ASSERT_EQ(chart.panels.size(), 1u);
  ASSERT_EQ(chart.panels[0].points.size(), 2u);
  const ChartRow &mesh = chart.panels[0].points[0], &plane = chart.panels[0].points[1];
  EXPECT_EQ(mesh.series, "mesh");
  EXPECT_EQ(mesh.name, "subdivision 2");
  EXPECT_EQ(mesh.cost.median, 12);
  EXPECT_EQ(mesh.error.median, 31.5);
  EXPECT_EQ(plane.series, "plane");
  EXPECT_EQ(plane.name, "subdivision as lumigraph");
  EXPECT_THAT(chart.title, testing::HasSubstr("vase"));
  EXPECT_THAT(chart.about,
              testing::HasSubstr("4 of 20 views left out; means over the 3 of them inside the hull"));
}

}  // namespace
}  // namespace ulf
