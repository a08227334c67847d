// Tests: render/fields/aperture, render/fields/aperture_field, commands/options/aperture_options.
//
// Wide apertures: the field's geometry against that of a lens, both renderers, the command line.
#include "render/fields/aperture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <random>

#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/fields/aperture_field.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/output/path_files.h"
#include "render/renderer/renderer.h"
#include "tests/render/scenes/agreement.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::aperture_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::RunUlf;
using testing::HasSubstr;

Rigid3 Facing(const Vector3d& center, const Vector3d& target = Vector3d::Zero()) {
  return LookAt(center, target, Vector3d::UnitY());
}

ApertureField FieldOf(const std::shared_ptr<RenderScene>& scene, int level) {
  return ApertureField(std::make_shared<MeshField>(scene, level));
}

FieldSample WeightsAlong(const PlacedField& field, const Rigid3& cam_from_world, const Vector3d& ray_in_cam) {
  FieldSample sample;
  field.Weights({cam_from_world.rotation.conjugate() * ray_in_cam.normalized(), Vector3d::Zero()}, sample);
  return sample;
}

// Where the ray of a view to the focal plane's point on `ray_in_cam` passes the aperture.
Vector2d ThroughAperture(const SceneView& view, const Rigid3& cam_from_world, const Vector3d& ray_in_cam,
                         double focus_depth) {
  const Vector3d w = cam_from_world * view.center_in_world, x = ray_in_cam / ray_in_cam.z() * focus_depth;
  return (w + (x - w) * (-w.z() / (x.z() - w.z()))).head<2>();
}

std::vector<Vector3d> Rays(int count, double spread, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-spread, spread);
  std::vector<Vector3d> rays;
  for (int i = 0; i < count; ++i) rays.emplace_back(uniform(random), uniform(random), 1);
  return rays;
}

// ---- The field ----

// Before the viewpoints, in their plane, and behind it: views weigh in exactly where their rays go through
// the disc, more the nearer to its middle.
TEST(ApertureField, WeighsTheRaysThatGoThroughTheDisc) {
  const auto scene =
      test::MakeScene({.viewpoints = test::GridViewpoints(17, 17, 0.1, 2.0), .width = 8, .height = 8});
  for (const int level : {0, 1, 2}) {
    const ApertureField field = FieldOf(scene, level);
    for (const double distance : {2.6, 2.0, 1.4})
      for (const Aperture& aperture :
           {Aperture{.radius = 0.4}, Aperture{.radius = 0.5, .focus_in_world = {0, 0, -1}}}) {
        const Rigid3 pose = Facing({0.02, 0.03, distance});
        const double focus = FocusDepth(aperture, pose);
        ASSERT_NEAR(focus, distance - aperture.focus_in_world.z(), 0.01);
        const auto here = field.From(pose, aperture);
        double squares = 0;
        const auto rays = Rays(12, 0.1, 3);
        for (const Vector3d& ray : rays) {
          const FieldSample sample = WeightsAlong(*here, pose, ray);
          double total = 0;
          for (const auto& [view, weight] : sample.weights) {
            const double through =
                ThroughAperture(scene->views[static_cast<std::size_t>(view)], pose, ray, focus).norm();
            ASSERT_GT(weight, 0);
            EXPECT_LT(through, 1.02 * aperture.radius) << "level " << level << " from " << distance;
            total += weight;
            squares += weight * through * through;
          }
          EXPECT_NEAR(total, 1, 1e-9);
          for (std::size_t i = 0; i < scene->views.size(); ++i) {
            const bool weighs =
                std::any_of(sample.weights.begin(), sample.weights.end(),
                            [&](const ViewWeight& w) { return w.view == static_cast<int>(i); });
            const bool well_inside =
                ThroughAperture(scene->views[i], pose, ray, focus).norm() < 0.6 * aperture.radius;
            EXPECT_TRUE(weighs || !well_inside) << "level " << level << " from " << distance;
          }
        }
        // A cone over the disc has 0.55 of its radius, one over a hexagon in it 0.46; splines less.
        const double rms = std::sqrt(squares / static_cast<double>(rays.size())) / aperture.radius;
        EXPECT_GT(rms, 0.3) << "level " << level << " from " << distance;
        EXPECT_LT(rms, 0.6) << "level " << level << " from " << distance;
      }
  }
}

TEST(ApertureField, AllViewsAlikeWhereItIsHuge) {
  const auto scene =
      test::MakeScene({.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0), .width = 8, .height = 8});
  const ApertureField linear = FieldOf(scene, 0);
  for (const double distance : {2.5, 2.0, 1.2}) {
    const Rigid3 pose = Facing({0.03, 0.02, distance});
    const auto here = linear.From(pose, {.radius = 1e5});
    for (const Vector3d& ray : Rays(20, 0.1, 4)) {
      const FieldSample sample = WeightsAlong(*here, pose, ray);
      ASSERT_EQ(sample.weights.size(), scene->views.size());
      for (const ViewWeight& entry : sample.weights) EXPECT_NEAR(entry.weight, 1.0 / 30, 1e-4);
    }
  }
}

// A ragged rim, where the extension overlaps the mesh: ten times smaller steps change the weights ten times
// less.
TEST(ApertureField, IsContinuousInTheRadius) {
  auto viewpoints = test::CapViewpoints(90, 0.7, 2.0, 0.03);
  std::erase_if(viewpoints, [](const Vector3d& v) { return v.x() > 0.3 && std::abs(v.y()) < 0.35; });
  const auto scene = test::MakeScene({.viewpoints = viewpoints, .width = 8, .height = 8});
  const ApertureField field = FieldOf(scene, 1);
  for (const double distance : {2.6, 1.3}) {
    const Rigid3 pose = Facing({0.2, 0.1, distance}, {0.1, 0, 0});
    const auto rays = Rays(40, 0.35, 5);
    const auto weights_at = [&](double radius) {
      std::vector<std::vector<double>> weights;
      const auto here = field.From(pose, {.radius = radius});
      for (const Vector3d& ray : rays) {
        std::vector<double>& of_ray = weights.emplace_back(scene->views.size(), 0.0);
        for (const ViewWeight& entry : WeightsAlong(*here, pose, ray).weights)
          of_ray[static_cast<std::size_t>(entry.view)] += entry.weight;
      }
      return weights;
    };
    const auto most_change = [&](double from, double to, int steps) {
      double most = 0;
      auto before = weights_at(from);
      for (int i = 1; i <= steps; ++i) {
        const auto now = weights_at(from + (to - from) * i / steps);
        for (std::size_t r = 0; r < rays.size(); ++r) {
          double change = 0;
          for (std::size_t v = 0; v < now[r].size(); ++v) change += std::abs(now[r][v] - before[r][v]);
          most = std::max(most, change);
        }
        before = now;
      }
      return most;
    };
    const double coarse = most_change(0, 0.6, 12), fine = most_change(0, 0.6, 120);
    EXPECT_GT(coarse, 0.1);
    EXPECT_LT(fine, 0.3 * coarse) << "from " << distance;
  }
}

TEST(ApertureField, IsTheOrdinaryOneWhileItIsSmall) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(60, M_PI, 2.0, 0.03)});
  const Rigid3 pose = Facing({0.1, 0.05, 2.4});
  const CameraModel camera = CameraModel::Pinhole(64, 48, 80);
  const Aperture small{.radius = 0.03, .focus_in_world = {0, 0, 0.1}};
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const auto renderer = MakeRenderer(scene, {.renderer = kind});
    const Rendering before = renderer->Render(camera, pose);
    renderer->SetAperture(small);
    const Rendering narrow = renderer->Render(camera, pose);
    renderer->SetAperture(Aperture{.radius = 0, .focus_in_world = small.focus_in_world});
    EXPECT_EQ(cv::norm(narrow.linear, renderer->Render(camera, pose).linear), 0);
    const auto focused = MakeRenderer(WithFocalPlane(*scene, small), {.renderer = kind});
    EXPECT_EQ(cv::norm(narrow.linear, focused->Render(camera, pose).linear), 0);
    renderer->SetAperture(std::nullopt);
    EXPECT_EQ(cv::norm(before.linear, renderer->Render(camera, pose).linear), 0);
    EXPECT_GT(cv::norm(before.linear, narrow.linear), 0);
  }
}

// ---- Renderers ----

TEST(GlAperture, EqualsTheReference) {
  struct Case {
    std::string name;
    test::SceneSpec spec;
    FieldOptions field;
  };
  const auto cap = test::CapViewpoints(45, 0.7, 2.0, 0.03);
  const std::vector<Case> cases{{"cap", {.viewpoints = cap, .width = 160, .height = 120, .focal_px = 70}, {}},
                                {"cap, linear",
                                 {.viewpoints = cap, .distortion = Distortion::kRadialTangential},
                                 {.kind = FieldKind::kLinear}},
                                {"sphere", {.viewpoints = test::CapViewpoints(60, M_PI, 2.0)}, {}},
                                {"grid", {.viewpoints = test::GridViewpoints(7, 6, 0.2, 2.0)}, {}}};
  const std::vector<std::pair<Rigid3, Aperture>> shots{
      {Facing({0.2, 0.1, 2.9}), {.radius = 0.9}},
      {Facing({0.1, -0.05, 1.0}), {.radius = 0.3, .focus_in_world = {0, 0, -0.7}}},
      {Facing(cap[20], {0.02, -0.01, 0}), {.radius = 0.5, .focus_in_world = {0, 0, 0.4}}},
      {Facing({1.4, 0.3, 1.6}), {.radius = 0.4}}};
  const CameraModel camera = CameraModel::Pinhole(64, 48, 80);
  for (const Case& c : cases) {
    const auto scene = test::MakeScene(c.spec);
    const auto gl = MakeRenderer(scene, {.field = c.field, .renderer = RendererKind::kGl});
    const auto reference = MakeRenderer(scene, {.field = c.field, .renderer = RendererKind::kReference});
    for (std::size_t shot = 0; shot < shots.size(); ++shot) {
      if (&c != &cases.front() && shot % 2 == 0) continue;
      const auto& [pose, aperture] = shots[shot];
      const std::string name = c.name + ", shot " + std::to_string(shot);
      for (const auto& renderer : {gl.get(), reference.get()}) renderer->SetAperture(aperture);
      const Rendering fast = gl->Render(camera, pose), plain = reference->Render(camera, pose);
      const cv::Mat band =
          test::VisibilityBand(*scene, {.field = reference->field(), .aperture = aperture}, camera, pose);
      const test::Agreement agreement = test::Compare(fast, plain, band);
      EXPECT_GE(agreement.within_share, 0.999) << name;
      EXPECT_GE(agreement.within_share_of_all, 0.99) << name;
      cv::Mat difference;
      cv::absdiff(fast.confidence, plain.confidence, difference);
      EXPECT_LT(cv::countNonZero(difference > 0.02), 0.01 * static_cast<double>(difference.total())) << name;
      EXPECT_NEAR(static_cast<double>(fast.filled_px), static_cast<double>(plain.filled_px), 24) << name;
    }
  }
}

// Photographs of a small bright spot, spread evenly over a grid.
std::shared_ptr<RenderScene> SpotScene(const Vector3d& spot, double sigma_px) {
  const auto scene = test::MakeScene(
      {.viewpoints = test::GridViewpoints(17, 17, 0.05, 2.0), .width = 64, .height = 64, .focal_px = 120});
  for (SceneView& view : scene->views) {
    const Vector2d at = *view.camera.ImgFromCam(view.cam_from_world * spot);
    cv::Mat light(view.camera.height, view.camera.width, CV_32FC3);
    for (int y = 0; y < light.rows; ++y)
      for (int x = 0; x < light.cols; ++x)
        light.at<cv::Vec3f>(y, x) = cv::Vec3f::all(static_cast<float>(
            std::exp(-(Vector2d(x + 0.5, y + 0.5) - at).squaredNorm() / (2 * sigma_px * sigma_px))));
    view.photograph = test::HoldPhotograph(MakeLinearPyramid(light));
  }
  return scene;
}

// Root mean square distance of the light from its centre, in pixels.
double Spread(const cv::Mat& linear) {
  double total = 0;
  Vector2d mean = Vector2d::Zero();
  double squares = 0;
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const double light = linear.at<cv::Vec3f>(y, x)[1];
      total += light;
      mean += light * Vector2d(x, y);
      squares += light * Vector2d(x, y).squaredNorm();
    }
  return std::sqrt(squares / total - (mean / total).squaredNorm());
}

// A lens of radius a focused at f shows a point at depth z as a disc of radius a |1/f - 1/z|, times the focal
// length in pixels.
TEST(Aperture, BlursAPointAsALensDoes) {
  const double focal_px = 120, sigma_px = 1.2;
  const CameraModel camera = CameraModel::Pinhole(48, 48, focal_px);
  for (const double spot_z : {-1.5, 0.5}) {
    const auto scene = SpotScene({0, 0, spot_z}, sigma_px);
    for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
      const auto renderer = MakeRenderer(scene, {.field = {.kind = FieldKind::kLinear}, .renderer = kind});
      for (const double distance : {2.0, 2.5})
        for (const double radius : {0.2, 0.35}) {
          if (kind == RendererKind::kReference && (distance > 2 || radius > 0.2)) continue;
          const Rigid3 pose = Facing({0, 0, distance});
          renderer->SetAperture(Aperture{.radius = radius});
          const double spread_px = Spread(renderer->Render(camera, pose).linear);
          const double disc_px = focal_px * radius * std::abs(1 / distance - 1 / (distance - spot_z));
          const double own_px =
              std::sqrt(2) * sigma_px * 2.0 / distance;  // projected from the views' distance
          const double share = std::sqrt(spread_px * spread_px - own_px * own_px) / disc_px;
          // A cone over the disc has 0.55 of its radius, one over a hexagon in it 0.46; sampling adds a
          // little.
          EXPECT_GT(share, 0.42) << renderer->Name() << ", " << spot_z << " from " << distance;
          EXPECT_LT(share, 0.6) << renderer->Name() << ", " << spot_z << " from " << distance;
          // Sharp where it is focused on the spot.
          renderer->SetAperture(Aperture{.radius = radius, .focus_in_world = {0, 0, spot_z}});
          const double scale = (2.0 - spot_z) / (distance - spot_z);
          EXPECT_NEAR(Spread(renderer->Render(camera, pose).linear), scale * std::sqrt(2) * sigma_px, 0.3);
        }
    }
  }
}

TEST(Aperture, TellsFNumbersAndFocus) {
  // 50 mm at f/2 on full frame: 12.5 mm.
  EXPECT_NEAR(ApertureRadius(2, 50.0 / 36 * 1920, 1920, 36), 0.0125, 1e-12);
  const Rigid3 pose = Facing({0, 0, 2});
  EXPECT_NEAR(FocusDepth({.focus_in_world = {1, 0.5, -1}}, pose), 3, 1e-12);
  EXPECT_GT(FocusDepth({.focus_in_world = {0, 0, 5}}, pose), 0);

  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)});
  const MeshProxy mesh(scene->subject, test::PlaneAndSquare());
  const CameraModel camera = CameraModel::Pinhole(160, 120, 200);
  const Vector3d on_square(0.1, 0.05, test::kSquareZ), on_plane(-0.5, 0.3, 0);
  for (const Vector3d& point : {on_square, on_plane}) {
    const Vector3d found = PointOnProxy(mesh, camera, pose, *camera.ImgFromCam(pose * point));
    EXPECT_LT((found - point).norm(), 1e-3);
  }
}

// ---- Paths and the command ----

TEST(Aperture, KeyframesHoldIt) {
  test::ScratchFolder scratch;
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)});
  const auto read = [&](const std::string& lenses0, const std::string& lenses1) {
    std::ofstream(scratch / "path.json")
        << R"({"keyframes": [{"time": 0, "eye": [0,0,2], "target": [0,0,0])" << lenses0
        << R"(}, {"time": 1, "eye": [0.2,0,2.5], "target": [0,0,0])" << lenses1 << "}]}";
    return PathFromFile(scratch / "path.json", {.frames = 5, .camera = CameraModel::Pinhole(64, 48, 60)},
                        *scene);
  };
  const CameraPath path = read(R"(, "aperture": 0.1, "focus": 1)", R"(, "aperture": 0.3, "focus": 4)");
  ASSERT_EQ(path.apertures.size(), 5u);
  EXPECT_NEAR(path.apertures[2].radius, 0.2, 1e-9);
  EXPECT_NEAR(FocusDepth(path.apertures[2], path.cam_from_world[2]), 2, 1e-9);
  EXPECT_NEAR(FocusDepth(path.apertures[4], path.cam_from_world[4]), 4, 1e-9);
  const CameraPath on_target = read(R"(, "aperture": 0.1)", R"(, "aperture": 0)");
  EXPECT_NEAR(FocusDepth(on_target.apertures[0], on_target.cam_from_world[0]), 2, 1e-9);
  EXPECT_EQ(on_target.apertures[4].radius, 0);
  EXPECT_TRUE(read("", "").apertures.empty());
  for (const auto& [first, second] : std::vector<std::pair<std::string, std::string>>{
           {R"(, "aperture": 0.1)", ""},
           {R"(, "aperture": -1)", R"(, "aperture": 1)"},
           {R"(, "focus": 1)", R"(, "focus": 1)"},
           {R"(, "aperture": 1, "focus": 0)", R"(, "aperture": 1, "focus": 1)"}})
    EXPECT_THROW(read(first, second), Error) << first << second;
}

TEST(Aperture, IsReadFromTheCommandLine) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), out = (scratch / "out").string();
  test::WriteLightField(dir, {.viewpoints = test::GridViewpoints(4, 4, 0.2, 2.0)}, true);
  const auto render = [&](const std::string& options) {
    return RunUlf("render " + dir +
                  " --path spiral --frames 2 --zoom 1 --width 48 --renderer reference --proxy plane -o " +
                  out + " " + options +
                  (options.find("--field") == std::string::npos ? " --field subdivision" : ""));
  };
  const auto wide = render("--aperture 0.4 --focus-at 24,18");
  ASSERT_EQ(wide.exit_code, 0) << wide.errors;
  EXPECT_EQ(render("--aperture 0.4 --focus-at 24,18").exit_code, 0);
  for (const char* other : {"", "--aperture 0.4 --focus 1"}) {
    const auto refused = render(other);
    EXPECT_EQ(refused.exit_code, 2) << other;
    EXPECT_THAT(refused.errors, HasSubstr("aperture")) << other;
  }
  struct Wrong {
    std::string options, says;
  };
  for (const Wrong& wrong : std::vector<Wrong>{{"--f-number 2", "arbitrary"},
                                               {"--focus 1", "--aperture"},
                                               {"--aperture 0.4 --focus-at 99,3", "48x36"},
                                               {"--aperture 0.4 --field lumigraph", "subdivision"}}) {
    const auto refused = render("--overwrite " + wrong.options);
    EXPECT_EQ(refused.exit_code, 2) << wrong.options;
    EXPECT_THAT(refused.errors, HasSubstr(wrong.says)) << wrong.options;
  }
}

}  // namespace
}  // namespace ulf::aperture_test
