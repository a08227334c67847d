// Tests: render/viewer/moving_size, render/viewer/viewer_state, render/viewer/viewpoint_gizmo,
// render/viewer/mesh_view.
//
// What the viewer is made of, each by itself: sizes, words, the sphere, the mesh's lines.
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "render/viewer/mesh_view.h"
#include "render/viewer/moving_size.h"
#include "render/viewer/viewer_state.h"
#include "render/viewer/viewpoint_gizmo.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test::viewer_parts_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(MovingSize, KeepsUpInSteps) {
  const cv::Size screen(1280, 720);
  const auto settle = [&](MovingSize& size, double ms_a_megapixel, int frames) {
    for (int i = 0; i < frames; ++i)
      size.AddFrame(ms_a_megapixel * 1e-6 * size.SizeFor(screen).area(), size.SizeFor(screen), screen);
    return size.SizeFor(screen).width;
  };
  MovingSize size;
  EXPECT_EQ(settle(size, 20, 5), 1280);
  size.AddFrame(3000, screen, screen);
  EXPECT_EQ(size.SizeFor(screen), screen) << "one slow frame says nothing";
  EXPECT_EQ(settle(size, 20, 1), 1280);
  EXPECT_EQ(settle(size, 270, 2), 454) << "at once";
  EXPECT_EQ(settle(size, 270, 20), 454) << "and stays";
  EXPECT_EQ(settle(size, 5000, 20), 320) << "no smaller";
  EXPECT_EQ(settle(size, 50, 20), 905);
  EXPECT_EQ(settle(size, 5, 20), 1280);
}

TEST(ViewerWords, SayTheSizeOfWhatIsSmallerAndTheFNumber) {
  ViewerState state;
  const auto words = [&](const ViewerFigures& figures) {
    std::string all;
    for (const StatusItem& item : StatusLine(state, figures)) all += item.text + "; ";
    return all;
  };
  ViewerFigures figures;
  EXPECT_THAT(words(figures), ::testing::Not(::testing::HasSubstr("drawn")));
  figures.drawn_size = {640, 360};
  EXPECT_THAT(words(figures), ::testing::HasSubstr("640x360"));
  state.aperture = 0.05;
  EXPECT_THAT(words(figures), ::testing::Not(::testing::HasSubstr("f/"))) << "no metres, no f-number";
  figures.f_number = FNumber(0.05, 1280, 1280, 36);  // 36 mm of focal length, 100 mm wide
  EXPECT_THAT(words(figures), ::testing::HasSubstr("(f/0.36)"));
  EXPECT_NEAR(ApertureRadius(*figures.f_number, 1280, 1280, 36), 0.05, 1e-12);
}

TEST(ViewpointGizmo, WarnsByTheHullAndTheDistances) {
  const ViewpointGizmo cap(*MakeScene({.viewpoints = CapViewpoints(80, 0.5, 2.0), .width = 8, .height = 6}));
  const Vector3d inside(0.3, 0.2, 1.96);
  EXPECT_EQ(cap.Warning(inside), "");
  EXPECT_THAT(cap.Warning({1.6, 0, 1.2}), ::testing::HasSubstr("outside"));
  EXPECT_THAT(cap.Warning(0.5 * inside), ::testing::HasSubstr("2.0 times nearer"));
  EXPECT_THAT(cap.Warning(3 * inside), ::testing::HasSubstr("3.0 times farther"));
  EXPECT_THAT(cap.Warning(0.1 * inside), ::testing::HasSubstr("inside the subject"));
  // A ring has no hull: beside its views is outside.
  const ViewpointGizmo ring(
      *MakeScene({.viewpoints = RingViewpoints(40, 0.2, 2.0), .width = 8, .height = 6}));
  EXPECT_EQ(ring.Warning(RingViewpoints(80, 0.2, 2.0)[1]), "");
  EXPECT_THAT(ring.Warning(RingViewpoints(80, 0.7, 2.0)[1]), ::testing::HasSubstr("outside"));
}

TEST(ViewpointGizmo, SaysWhatItCanAboutFewViews) {
  for (const std::vector<Vector3d>& viewpoints :
       {std::vector<Vector3d>{{0, 0, 2}, {0, 0, 2}}, std::vector<Vector3d>{{0, 0, 2}}}) {
    auto scene = *MakeScene({.viewpoints = {{0, 0, 2}, {0.1, 0, 2}}, .width = 8, .height = 6});
    scene.views.resize(viewpoints.size());
    for (std::size_t i = 0; i < viewpoints.size(); ++i) scene.views[i].center_in_world = viewpoints[i];
    scene.MakeMesh();
    const ViewpointGizmo where(scene);
    EXPECT_GT(where.Spacing(), 0);
    EXPECT_THAT(where.Warning({2, 0, 0}), ::testing::HasSubstr("outside"));
    EXPECT_FALSE(where.Draw({2, 0, 0}, 100).empty());
  }
}

TEST(ViewpointGizmo, TheDotGoesWhereTheCameraGoes) {
  const auto scene = MakeScene({.viewpoints = CapViewpoints(60, 0.4, 2.0), .width = 8, .height = 6});
  const ViewpointGizmo where(*scene);
  const ViewerCamera start = StartingCamera(*scene);
  const auto place = [&](const ViewerCamera& camera) { return where.PlaceOf(camera.eye_in_world, 100); };
  EXPECT_LT((place(start).img - Vector2d(50, 50)).norm(), 2);
  EXPECT_GT(place(Orbited(start, 0.5, 0)).img.x(), 65);
  EXPECT_LT(place(Orbited(start, -0.5, 0)).img.x(), 35);
  EXPECT_LT(place(Orbited(start, 0, 0.5)).img.y(), 35);
  EXPECT_TRUE(place(Orbited(start, 1.4, 0)).front);
  EXPECT_FALSE(place(Orbited(start, 2, 0)).front);
  // In the picture: a filled dot before, a ring behind.
  const auto spots = [&](const ViewerCamera& camera) {
    int count = 0;
    for (const OverlayShape& shape : where.Draw(camera.eye_in_world, 100))
      count += std::holds_alternative<Spot>(shape);
    return count;
  };
  EXPECT_GT(spots(start), spots(Orbited(start, 2, 0)));
}

TEST(MeshView, LinesMeetTheProjectedViewpoints) {
  const auto scene = MakeScene(
      {.viewpoints = GridViewpoints(7, 7, 0.15, 2.0), .width = 192, .height = 144, .focal_px = 160});
  const MeshField coarse(scene, 0), fine(scene, 1);
  for (const double distance :
       {4.0, 1.2}) {  // outside the shell, and past it: then they are behind the camera
    ViewerCamera from = StartingCamera(*scene);
    from.eye_in_world *= distance / from.Distance();
    const CameraModel camera = from.ModelFor({640, 480});
    std::vector<Vector2d> projected;
    for (const SceneView& view : scene->views) {
      Vector3d p = from.CamFromWorld() * view.center_in_world;
      if (p.z() < 0) p = -p;
      if (std::abs(p.z()) > 0.05 * p.norm())
        projected.push_back({camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy});
    }
    const auto meets = [&](const Vector2d& end) {
      return std::any_of(projected.begin(), projected.end(),
                         [&](const Vector2d& view) { return (view - end).norm() < 0.01; });
    };
    int thick = 0, thin = 0, ends_met = 0, viewpoints = 0;
    for (const OverlayShape& shape : MeshView(coarse, &fine, *scene, camera, from.CamFromWorld())) {
      if (const auto* spot = std::get_if<Spot>(&shape)) viewpoints += meets(spot->img);
      const auto* line = std::get_if<Polyline>(&shape);
      if (!line || (line->width < 2 && ++thin)) continue;
      ++thick;
      ends_met += meets(line->img.front()) + meets(line->img.back());
    }
    EXPECT_GT(thick, 90) << distance;
    EXPECT_GT(thin, 3 * thick) << distance;
    EXPECT_GT(ends_met, 1.9 * thick) << distance << ": but where an edge is cut off beside the camera";
    EXPECT_EQ(viewpoints, 2 * static_cast<int>(scene->views.size())) << distance;
  }
}

}  // namespace
}  // namespace ulf::test::viewer_parts_test
