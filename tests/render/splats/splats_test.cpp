// Tests: render/splats/splat_renderer, render/splats/color_fit, render/splats/placing,
// render/splats/make_splats, render/splats/splat_views, render/splats/surface_map, render/splats/far_sphere,
// render/splats/splat_shape.
//
// Gaussians of drawn scenes: pictures of one by its formula, of a plane and a square before it from places
// that gave no photograph, beside the mesh renderer's.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/geometry/pinhole.h"
#include "core/image/image.h"
#include "render/proxy/proxy.h"
#include "render/quality/quality.h"
#include "render/renderer/reference_renderer.h"
#include "render/splats/color_fit.h"
#include "render/splats/far_sphere.h"
#include "render/splats/make_splats.h"
#include "render/splats/splat_renderer.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::splats_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Gaussian Ball(const Vector3f& at, float radius, const Vector3f& rgb, float opacity = 0.9f) {
  Gaussian ball;
  ball.position_in_world = at;
  ball.scale = Vector3f::Constant(radius);
  ball.opacity = opacity;
  ball.harmonics[0] = (rgb - Vector3f::Constant(0.5f)) / 0.28209479f;
  return ball;
}

cv::Mat Bytes(const SplatPicture& picture) {
  cv::Mat bytes;
  picture.srgb.convertTo(bytes, CV_8U, 255);
  return bytes;
}

double Psnr(const cv::Mat& a, const cv::Mat& b) {
  return CompareImages(a, b, cv::Mat(a.size(), CV_8U, cv::Scalar(255))).psnr_db;
}

// A ball on the axis is a round Gaussian of f r / z pixels, with 0.3 px squared added; of two, the nearer one
// hides the other.
TEST(SplatRenderer, DrawsAGaussianByItsFormula) {
  const CameraModel camera = CameraModel::Pinhole(60, 40, 50);
  const Gaussians both{Ball({0, 0, 4}, 0.4f, {0, 0, 1}), Ball({0.2f, 0, 2}, 0.1f, {1, 0.5f, 0}, 0.8f)};
  const SplatPicture picture = DrawSplats(both, camera, Rigid3{});
  for (int y = 0; y < 40; y += 3)
    for (int x = 0; x < 60; x += 3) {
      const auto alpha = [&](double at_x, double sigma2_x, double sigma2_y, double opacity) {
        const double dx = x + 0.5 - at_x, dy = y + 0.5 - 20;
        const double value = opacity * std::exp(-0.5 * (dx * dx / sigma2_x + dy * dy / sigma2_y));
        return value < 1 / 255.0 ? 0 : value;
      };
      // The projection of a ball off the axis is longer by its depth: the derivative by z is f x / z^2.
      const double near = alpha(30 + 50 * 0.2 / 2, 0.3 + 2.5 * 2.5 * (1 + 0.1 * 0.1), 0.3 + 2.5 * 2.5, 0.8);
      const double far = alpha(30, 0.3 + 25, 0.3 + 25, 0.9);
      const auto& bgr = picture.srgb.at<cv::Vec3f>(y, x);
      EXPECT_NEAR(bgr[2], near, 2e-4) << x << " " << y;
      EXPECT_NEAR(bgr[1], 0.5 * near, 2e-4);
      EXPECT_NEAR(bgr[0], (1 - near) * far, 2e-4);
      EXPECT_NEAR(picture.opacity.at<float>(y, x), 1 - (1 - near) * (1 - far), 2e-4);
    }
}

TEST(SplatRenderer, SharesSumToTheOpacity) {
  const CameraModel camera = CameraModel::Pinhole(50, 40, 50);
  const Gaussians balls{Ball({0.3f, 0, 2}, 0.2f, {1, 0.5f, 0}), Ball({0, 0.2f, 3}, 0.5f, {0, 1, 0})};
  const SplatPicture picture = DrawSplats(balls, camera, Rigid3{});
  const SplatComparison comparison = CompareSplats(balls, camera, Rigid3{}, Bytes(picture), false);
  ASSERT_EQ(comparison.shares.size(), 2u);
  EXPECT_NEAR(comparison.shares[0].weight + comparison.shares[1].weight, cv::sum(picture.opacity)[0], 0.05);
  EXPECT_EQ(comparison.pixels, 50 * 40);
  EXPECT_LT(comparison.squared_error, 3 * 50 * 40 * std::pow(0.3 / 255, 2) * 2);
}

// Each ball shows another colour to each side: blue grows to the right of the world, red to the left.
TEST(ColorFit, FindsColoursThatDependOnDirection) {
  Gaussians truth;
  for (int i = 0; i < 9; ++i) {
    Gaussian ball = Ball({0.3f * static_cast<float>(i % 3 - 1), 0.3f * static_cast<float>(i / 3 - 1), 0},
                         0.1f, {0.5f, 0.2f + 0.05f * static_cast<float>(i), 0.5f}, 0.95f);
    ball.harmonics[3] = {0.5f, 0, -0.5f};
    truth.push_back(ball);
  }
  const CameraModel camera = CameraModel::Pinhole(96, 72, 80);
  std::vector<ColorFitView> views;
  for (const Vector3d& place : test::CapViewpoints(24, 0.7, 2.0)) {
    const Rigid3 pose = LookAt(place, Vector3d::Zero(), Vector3d::UnitY());
    views.push_back({camera, pose, Bytes(DrawSplats(truth, camera, pose))});
  }
  Gaussians fitted = truth;
  for (Gaussian& gaussian : fitted) gaussian.harmonics.fill(Vector3f::Zero());
  const ColorFitSummary summary = FitColors(views, fitted, {.rounds = 12, .at_once = 8});
  EXPECT_GT(summary.psnr_db.back(), 40);
  const Rigid3 left_out = LookAt({0.7, 0.3, 1.8}, Vector3d::Zero(), Vector3d::UnitY());
  EXPECT_GT(Psnr(Bytes(DrawSplats(fitted, camera, left_out)), Bytes(DrawSplats(truth, camera, left_out))),
            40);
  // Without change by direction it would be a difference of 0.1 from side to side.
  EXPECT_NEAR(fitted[4].harmonics[3].z(), -0.5f, 0.2f);
}

// Opacities and sizes that were guessed are found again, as far as the pictures tell them.
TEST(ColorFit, FindsOpacitiesAndSizes) {
  Gaussians truth;
  for (int i = 0; i < 25; ++i) {
    const auto column = static_cast<float>(i % 5 - 2), row = static_cast<float>(i / 5 - 2);
    truth.push_back(Ball({0.2f * column, 0.2f * row, 0}, i % 2 == 0 ? 0.08f : 0.05f,
                         {0.9f, 0.2f + 0.02f * static_cast<float>(i), 0.3f}, i % 3 == 0 ? 0.95f : 0.5f));
    truth.push_back(Ball({0.2f * column, 0.2f * row, -0.3f}, 0.09f, {0.1f, 0.3f, 0.8f}, 0.9f));
  }
  const CameraModel camera = CameraModel::Pinhole(96, 72, 80);
  std::vector<ColorFitView> views;
  for (const Vector3d& place : test::CapViewpoints(12, 0.6, 2.0)) {
    const Rigid3 pose = LookAt(place, Vector3d::Zero(), Vector3d::UnitY());
    views.push_back({camera, pose, Bytes(DrawSplats(truth, camera, pose))});
  }
  const auto begin = [&] {
    Gaussians guessed = truth;
    for (Gaussian& gaussian : guessed) {
      gaussian.scale = Vector3f::Constant(0.065f);
      gaussian.opacity = 0.75f;
    }
    return guessed;
  };
  Gaussians fitted = begin(), only_colors = begin();
  const double db = FitColors(views, fitted, {.rounds = 12}).psnr_db.back();
  const double colors_db = FitColors(views, only_colors, {.rounds = 12, .shapes = false}).psnr_db.back();
  EXPECT_GT(db, colors_db + 5);
  EXPECT_GT(fitted[0].scale.x(), 0.07f);
  EXPECT_LT(fitted[2].scale.x(), 0.06f);
}

// The drawn scene, its mesh as proxy, without its first view.
struct DrawnScene {
  std::shared_ptr<const RenderScene> scene;
  SceneView left_out;
};

DrawnScene DrawScene(bool with_square, Distortion distortion = Distortion::kNone) {
  auto all = test::MakeScene({.viewpoints = test::CapViewpoints(13, 0.5, 2.0, 0.05),
                              .width = 160,
                              .height = 120,
                              .focal_px = 140,
                              .distortion = distortion,
                              .with_square = with_square});
  const auto proxy = std::make_shared<MeshProxy>(all->subject, test::PlaneAndSquare());
  return {WithProxy(*Without(*all, {0}), proxy), all->views[0]};
}

struct Compared {
  double splats_db, mesh_db;
};

Compared Compare(const DrawnScene& drawn, const Gaussians& gaussians, bool with_square) {
  const CameraModel camera = drawn.left_out.camera.WithoutDistortion();
  const Rigid3& pose = drawn.left_out.cam_from_world;
  const cv::Mat truth = test::PhotographOfPlane(camera, pose, with_square);
  ReferenceRenderer renderer(drawn.scene, {.field = {.kind = FieldKind::kLumigraphPerPixel}});
  return {Psnr(Bytes(DrawSplats(gaussians, camera, pose)), truth),
          Psnr(Srgb8FromLinear(renderer.Render(camera, pose).linear), truth)};
}

TEST(MakeSplats, LeftOutViewsComeNearTheMeshRenderers) {
  for (const bool with_square : {false, true}) {
    const DrawnScene drawn = DrawScene(with_square);
    const Splats splats = MakeSplats(*drawn.scene, {});
    const Compared compared = Compare(drawn, splats.gaussians, with_square);
    EXPECT_GT(compared.splats_db, compared.mesh_db - 3) << with_square;
    EXPECT_GT(compared.splats_db, 25) << with_square;
    RecordProperty(with_square ? "square_db" : "plane_db", std::to_string(compared.splats_db));
  }
}

TEST(MakeSplats, TakesOutDistortion) {
  const DrawnScene drawn = DrawScene(false, Distortion::kRadialTangential);
  const Splats splats = MakeSplats(*drawn.scene, {});
  const Compared compared = Compare(drawn, splats.gaussians, false);
  EXPECT_GT(compared.splats_db, compared.mesh_db - 3);
}

// Fewer Gaussians are coarser everywhere: no part of the picture is left to the background.
TEST(MakeSplats, AreCoarserWithEveryCount) {
  const DrawnScene drawn = DrawScene(true);
  const Splats many = MakeSplats(*drawn.scene, {});
  double last_db = Compare(drawn, many.gaussians, true).splats_db;
  for (const std::size_t share : {2u, 4u}) {
    const std::size_t most = many.gaussians.size() / share;
    const Splats few = MakeSplats(*drawn.scene, {.most = most});
    EXPECT_LE(few.gaussians.size(), most);
    EXPECT_GT(few.gaussians.size(), most / 2) << share;
    const double db = Compare(drawn, few.gaussians, true).splats_db;
    EXPECT_LT(db, last_db + 0.5) << share;
    EXPECT_GT(db, last_db - 4) << share;
    last_db = db;
  }
}

// A viewer that comes twice as near shows the surface, not dots with gaps between them.
TEST(MakeSplats, StayClosedFromNearer) {
  const DrawnScene drawn = DrawScene(false);
  const Splats splats = MakeSplats(*drawn.scene, {.most = 8000});
  CameraModel camera = drawn.left_out.camera;
  camera.fx *= 2;
  camera.fy *= 2;
  const Rigid3& pose = drawn.left_out.cam_from_world;
  const cv::Mat truth = test::PhotographOfPlane(camera, pose, false);
  const double near_db = Psnr(Bytes(DrawSplats(splats.gaussians, camera, pose)), truth);
  EXPECT_GT(near_db, Compare(drawn, splats.gaussians, false).splats_db - 1.5);
}

// Each part of the plane is in the picture of one view alone, so that no other map confirms its own.
TEST(MakeSplats, ShowWhatOneViewAloneSaw) {
  const auto all = test::MakeScene({.viewpoints = {{-1.6, 0, 2}, {0, 0, 2}, {1.6, 0, 2}, {0.05, 0, 2}},
                                    .width = 160,
                                    .height = 120,
                                    .focal_px = 140});
  RenderScene turned = *all;
  for (SceneView& view : turned.views) {  // straight down
    view.cam_from_world = LookAt(view.center_in_world, {view.center_in_world.x(), 0, 0}, Vector3d::UnitY());
    view.photograph =
        test::HoldPhotograph(MakePyramid(test::PhotographOfPlane(view.camera, view.cam_from_world)));
  }
  const auto proxy = std::make_shared<MeshProxy>(turned.subject, test::PlaneAndSquare());
  const DrawnScene drawn{WithProxy(*Without(turned, {3}), proxy), turned.views[3]};
  const Splats splats = MakeSplats(*drawn.scene, {});
  const Compared compared = Compare(drawn, splats.gaussians, false);
  EXPECT_GT(compared.splats_db, compared.mesh_db - 3);
}

// A thin board, red above and blue below, each with stripes of its own; what is beside it is grey.
cv::Mat PhotographOfBoard(const CameraModel& camera, const Rigid3& cam_from_world) {
  const Vector3d center = cam_from_world.OriginInSource();
  const bool from_above = center.z() > 0;
  cv::Mat bgr(camera.height, camera.width, CV_8UC3, cv::Scalar::all(100));
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const Vector3d ray = cam_from_world.DirectionInSource(PinholeRay(camera, x, y));
      const Vector3d at = center - center.z() / ray.z() * ray;
      if (at.head<2>().cwiseAbs().maxCoeff() > 0.6) continue;
      const double stripe = std::sin(25 * (from_above ? at.x() : at.y())) > 0 ? 220 : 90;
      bgr.at<cv::Vec3b>(y, x) = from_above ? cv::Vec3b(20, 20, cv::saturate_cast<std::uint8_t>(stripe))
                                           : cv::Vec3b(cv::saturate_cast<std::uint8_t>(stripe), 20, 20);
    }
  return bgr;
}

// Nobody sees a surface from behind, however thin what it belongs to is.
TEST(MakeSplats, KeepBothSidesOfAThinBoard) {
  std::vector<Vector3d> viewpoints;
  for (const double side : {1, -1})
    for (const Vector3d& at : test::CapViewpoints(7, 0.5, 2.0, 0.05))
      viewpoints.emplace_back(at.x(), at.y(), side * at.z());
  const auto all = test::MakeScene({.viewpoints = viewpoints, .width = 160, .height = 120, .focal_px = 140});
  RenderScene scene = *all;
  for (SceneView& view : scene.views)
    view.photograph = test::HoldPhotograph(MakePyramid(PhotographOfBoard(view.camera, view.cam_from_world)));
  auto board = std::make_shared<TriangleMesh>();
  for (const float z : {0.001f, -0.001f})
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      board->vertices.emplace_back(0.6f * static_cast<float>(x), 0.6f * static_cast<float>(y), z);
  board->triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
  const auto proxy = std::make_shared<MeshProxy>(scene.subject, board);
  const Splats splats = MakeSplats(*WithProxy(*Without(scene, {0, 7}), proxy), {});
  for (const std::size_t left_out : {0u, 7u}) {
    const SceneView& view = scene.views[left_out];
    EXPECT_GT(Psnr(Bytes(DrawSplats(splats.gaussians, view.camera, view.cam_from_world)),
                   PhotographOfBoard(view.camera, view.cam_from_world)),
              22)
        << left_out;
  }
}

// What stands before the backdrop in one view does not colour it, if another view sees past it.
TEST(MakeSplats, TakeTheBackdropFromWhoSeesIt) {
  std::vector<SplatView> views(2);
  for (SplatView& view : views) {
    view.camera = CameraModel::Pinhole(80, 60, 70);
    view.photograph = view.means[0] = cv::Mat::zeros(60, 80, CV_8UC3);
    view.done = cv::Mat::zeros(60, 80, CV_8U);
  }
  Gaussians past;
  AddBackdrop(views, 100000, past);
  views[1].means[0] = cv::Mat(60, 80, CV_8UC3, cv::Scalar::all(255));
  views[1].done.setTo(1);
  Gaussians before;
  AddBackdrop(views, 100000, before);
  ASSERT_GT(past.size(), 100u);
  ASSERT_EQ(before.size(), past.size());
  for (std::size_t i = 0; i < past.size(); ++i) EXPECT_EQ(before[i].harmonics[0], past[i].harmonics[0]);
  views[0].done.setTo(1);
  Gaussians hidden;
  AddBackdrop(views, 100000, hidden);
  ASSERT_EQ(hidden.size(), past.size());
  EXPECT_GT(hidden[0].harmonics[0].x(), past[0].harmonics[0].x()) << "better a mean than black";
}

// Where the mesh ends, views still show something.
TEST(MakeSplats, FillsWhatGeometryLacks) {
  DrawnScene drawn = DrawScene(false);
  auto half = std::make_shared<TriangleMesh>();
  half->vertices = {{-9, -9, 0}, {0, -9, 0}, {0, 9, 0}, {-9, 9, 0}};
  half->triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto scene = WithProxy(*drawn.scene, std::make_shared<MeshProxy>(drawn.scene->subject, half));
  const Splats splats = MakeSplats(*scene, {});
  EXPECT_GT(splats.around, 100u);
  for (const SceneView& view : scene->views) {
    const SplatPicture picture =
        DrawSplats(splats.gaussians, view.camera.WithoutDistortion(), view.cam_from_world);
    EXPECT_GT(cv::mean(picture.opacity)[0], 0.98);
  }
}

// A picture that reaches ten degrees beyond all photographs shows about the right colours there.
TEST(MakeSplats, AreNotBlackWhereNobodyLooked) {
  const DrawnScene drawn = DrawScene(false);
  const Splats splats = MakeSplats(*drawn.scene, {});
  CameraModel camera = drawn.left_out.camera;
  camera.fx = camera.fy = 90;
  const SplatPicture picture = DrawSplats(splats.gaussians, camera, drawn.left_out.cam_from_world);
  EXPECT_GT(cv::mean(picture.opacity)[0], 0.97);
  EXPECT_GT(Psnr(Bytes(picture), test::PhotographOfPlane(camera, drawn.left_out.cam_from_world)), 15);
}

// The same numbers, whatever the threads.
TEST(MakeSplats, AreTheSameEveryTime) {
  const DrawnScene drawn = DrawScene(true);
  const Splats one = MakeSplats(*drawn.scene, {.most = 4000}), two = MakeSplats(*drawn.scene, {.most = 4000});
  ASSERT_EQ(one.gaussians.size(), two.gaussians.size());
  for (std::size_t i = 0; i < one.gaussians.size(); ++i) {
    EXPECT_EQ(one.gaussians[i].position_in_world, two.gaussians[i].position_in_world);
    for (std::size_t h = 0; h < 4; ++h)
      EXPECT_EQ(one.gaussians[i].harmonics[h], two.gaussians[i].harmonics[h]);
  }
}

}  // namespace
}  // namespace ulf::splats_test
