// Tests: render/renderer/soft_pixel, render/gl/gl_depth_maps, render/proxy/soft_proxy,
// render/proxy/view_depth_map.
// A small square before a plane, of which the mesh knows nothing and the views' maps do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/soft_proxy.h"
#include "render/quality/quality.h"
#include "render/renderer/reference_renderer.h"
#include "render/renderer/soft_pixel.h"
#include "tests/render/scenes/agreement.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test::soft_pixel_test {
namespace {

using Eigen::Vector3d;

const CameraModel kPictureCamera = CameraModel::Pinhole(192, 144, 160);
constexpr double kStep =
    0.004;  // of the maps, in inverse depth: a hundredth of the square's distance before the plane

TriangleMesh PlaneAlone() {
  TriangleMesh plane = *PlaneAndSquare();
  std::erase_if(plane.triangles,
                [&](const auto& triangle) { return std::abs(plane.vertices[triangle[0]].z()) > 1e-6; });
  return plane;
}

// A view's map of plane and square.
ViewDepthMap TrueMap(const SceneView& view, double noise_steps, std::mt19937& random) {
  const CameraModel camera = view.camera.WithoutDistortion();
  cv::Mat inverse_depth = DrawInverseDepth(*PlaneAndSquare(), camera, view.cam_from_world);
  std::normal_distribution<float> noise(0, static_cast<float>(noise_steps * kStep));
  for (int y = 0; y < inverse_depth.rows; ++y)
    for (int x = 0; x < inverse_depth.cols; ++x) inverse_depth.at<float>(y, x) += noise(random);
  return MakeViewDepthMap(camera, inverse_depth, kStep);
}

struct SoftSpec {
  double noise_steps = 0;
  int views_without_map = 0;  // of each eight
  int views_that_lie = 0;     // of each eight: the maps put a surface half-way to the camera
};

std::shared_ptr<const RenderScene> SoftScene(const RenderScene& scene, const SoftSpec& spec = {}) {
  std::mt19937 random(3);
  SoftProxy::Maps maps;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const int of_eight = static_cast<int>(i % 8);
    if (of_eight < spec.views_without_map) continue;
    ViewDepthMap map = TrueMap(scene.views[i], spec.noise_steps, random);
    if (of_eight >= 8 - spec.views_that_lie) map.unit *= 2;
    maps.emplace(scene.views[i].id, std::make_shared<LazyDepthMap>([map] { return map; }));
  }
  return WithProxy(
      scene, std::make_shared<SoftProxy>(scene.subject, std::make_shared<TriangleMesh>(PlaneAlone()), maps));
}

SceneSpec SquareSpec() {
  return {.viewpoints = CapViewpoints(24, 0.6, 2.0, 0.03),
          .width = 192,
          .height = 144,
          .focal_px = 160,
          .with_square = true};
}

// Made once: nobody changes it.
std::shared_ptr<const RenderScene> SoftSquareScene() {
  static const std::shared_ptr<const RenderScene> scene = SoftScene(*MakeScene(SquareSpec()));
  return scene;
}

Rigid3 Between(double x = 0.21, double y = 0.12) {
  return LookAt(Vector3d(x, y, 2.0).normalized() * 2.05, Vector3d::Zero(), Vector3d::UnitY());
}

// Of the square and what is around it.
double PsnrOfSquare(const RenderScene& scene, const FieldOptions& field, const Rigid3& pose) {
  const auto renderer = MakeRenderer(std::shared_ptr<const RenderScene>(&scene, [](const RenderScene*) {}),
                                     {.field = field, .renderer = RendererKind::kReference});
  const cv::Mat picture = Srgb8FromLinear(renderer->Render(kPictureCamera, pose).linear);
  const cv::Mat truth = PhotographOfPlane(kPictureCamera, pose, true);
  const cv::Rect square(66, 46, 60, 60);
  return cv::PSNR(picture(square), truth(square));
}

constexpr FieldOptions kSoft{.kind = FieldKind::kSoft};

TEST(SoftPixel, ShowsWhatTheMeshDoesNotKnow) {
  const auto scene = SoftSquareScene();
  const double by_mesh = PsnrOfSquare(*scene, {.kind = FieldKind::kLumigraphPerPixel}, Between());
  const double soft = PsnrOfSquare(*scene, kSoft, Between());
  RecordProperty("by_mesh_db", std::to_string(by_mesh));
  RecordProperty("soft_db", std::to_string(soft));
  EXPECT_GT(soft, by_mesh + 6);
}

TEST(SoftPixel, MapsThatLieAreOutvoted) {
  const auto scene = MakeScene(SquareSpec());
  const double all_right = PsnrOfSquare(*SoftSquareScene(), kSoft, Between());
  const double one_of_eight = PsnrOfSquare(*SoftScene(*scene, {.views_that_lie = 1}), kSoft, Between());
  const double noisy = PsnrOfSquare(*SoftScene(*scene, {.noise_steps = 1}), kSoft, Between());
  EXPECT_GT(one_of_eight, all_right - 2);
  EXPECT_GT(noisy, all_right - 1.5);
}

TEST(SoftPixel, ViewsWithoutAMapUseTheMeshsDepth) {
  const auto scene = SoftScene(*MakeScene(SquareSpec()), {.views_without_map = 2});
  int on_square = 0;
  for (const SceneView& view : scene->views) {
    ASSERT_TRUE(view.depth_map);
    const ViewDepthMap& map = view.depth_map->Get();
    EXPECT_GT(map.step, 0);
    // The principal ray meets the square, of which the mesh knows nothing, or passes it and meets the plane.
    const double depth = 1 / map.InverseDepthAt(map.camera.width / 2, map.camera.height / 2);
    const double to_plane = view.center_in_world.norm();
    const bool has_own = static_cast<std::size_t>(&view - scene->views.data()) % 8 >= 2;
    if (!has_own) {
      EXPECT_NEAR(depth, to_plane, 0.03) << view.id;
    }
    on_square += has_own && depth < to_plane - 0.3;
  }
  EXPECT_GT(on_square, 3);
  EXPECT_GT(PsnrOfSquare(*scene, kSoft, Between()),
            PsnrOfSquare(*scene, {.kind = FieldKind::kLumigraphPerPixel}, Between()) + 1);
}

// A photograph with a passer-by: over half of the picture it is black.
TEST(SoftPixel, OneViewThatDisagreesHasLittleSay) {
  auto scene = MakeScene({.viewpoints = CapViewpoints(60, 0.6, 2.0, 0.03)});
  const Rigid3 pose = Between();
  const cv::Mat truth = PhotographOfPlane(kPictureCamera, pose);
  const auto error = [&](const FieldOptions& field) {
    const auto renderer = MakeRenderer(scene, {.field = field, .renderer = RendererKind::kReference});
    cv::Mat difference;
    cv::absdiff(Srgb8FromLinear(renderer->Render(kPictureCamera, pose).linear), truth, difference);
    return cv::mean(difference.reshape(1))[0];
  };
  const double soft_before = error(kSoft), lumigraph_before = error({.kind = FieldKind::kLumigraphPerPixel});
  const auto nearest = std::ranges::min_element(scene->views, {}, [&](const SceneView& view) {
    return (view.center_in_world - pose.OriginInSource()).norm();
  });
  cv::Mat passed = nearest->photograph->Level(0).clone();
  passed.colRange(0, passed.cols / 2).setTo(0);
  nearest->photograph = HoldPhotograph({passed});
  const double soft = error(kSoft) - soft_before,
               lumigraph = error({.kind = FieldKind::kLumigraphPerPixel}) - lumigraph_before;
  EXPECT_GT(lumigraph, 2);
  EXPECT_LT(soft, 0.5 * lumigraph);
}

// Light that changes with the direction from which it is seen; most views stand on one side.
TEST(SoftPixel, LightThatFollowsTheDirectionIsBalanced) {
  SceneSpec spec;
  const Rigid3 pose = Between(0, 0);
  for (const Vector3d& center : CapViewpoints(80, 0.6, 2.0, 0.03))
    if (center.x() > -0.15) spec.viewpoints.push_back(center);
  auto scene = MakeScene(spec);
  const auto light_from = [](const Vector3d& center) { return 0.3 + 0.4 * center.x(); };
  for (SceneView& view : scene->views) {
    const cv::Mat one_light(view.camera.height, view.camera.width, CV_32FC3,
                            cv::Scalar::all(light_from(view.center_in_world)));
    view.photograph = HoldPhotograph({Srgb8FromLinear(one_light)});
  }
  const auto shift = [&](RendererKind kind) {
    const auto renderer =
        MakeRenderer(scene, {.field = {.kind = FieldKind::kSoft, .soft_width = kWideSoft}, .renderer = kind});
    const cv::Mat picture = renderer->Render(kPictureCamera, pose).linear;
    const cv::Rect middle(kPictureCamera.width / 2 - 8, kPictureCamera.height / 2 - 8, 16, 16);
    return std::abs(cv::mean(picture(middle))[0] - light_from(pose.OriginInSource()));
  };
  // 0.0215 without the balance.
  EXPECT_LT(shift(RendererKind::kReference), 0.018);
  EXPECT_LT(shift(RendererKind::kGl), 0.018);
}

// So narrow that every view would lose all its weight where several are equally near.
TEST(SoftPixel, NarrowWeightsLeaveNoHoles) {
  const auto scene = SoftSquareScene();
  for (const RendererKind kind : {RendererKind::kReference, RendererKind::kGl}) {
    const auto empty = [&](double width) {
      return MakeRenderer(scene, {.field = {.kind = FieldKind::kSoft, .soft_width = width}, .renderer = kind})
          ->Render(kPictureCamera, Between())
          .empty_px;
    };
    EXPECT_EQ(empty(0.1), empty(0.8));
  }
}

TEST(SoftPixel, OnAViewpointItsPhotographComesBack) {
  const auto scene = SoftSquareScene();
  const SceneView& view = scene->views[7];
  const auto renderer = MakeRenderer(scene, {.field = kSoft, .renderer = RendererKind::kReference});
  const cv::Mat picture = Srgb8FromLinear(renderer->Render(view.camera, view.cam_from_world).linear);
  EXPECT_GT(cv::PSNR(picture, view.Srgb8()), 45);
}

TEST(SoftPixel, WeightsSumToOne) {
  const auto scene = SoftSquareScene();
  const auto renderer =
      MakeRenderer(scene, {.field = kSoft, .renderer = RendererKind::kReference, .weights = true});
  const Rendering picture = renderer->Render(kPictureCamera, Between());
  cv::Mat sum = cv::Mat::zeros(picture.drawn.size(), CV_32F), one;
  for (const ViewWeights& view : picture.weights) {
    view.weight.convertTo(one, CV_32F);
    sum += one;
  }
  EXPECT_GT(picture.weights.size(), 8u);
  double least = 0, most = 0;
  cv::minMaxLoc(sum, &least, &most, nullptr, nullptr, picture.drawn);
  EXPECT_NEAR(least, 1, 0.01);
  EXPECT_NEAR(most, 1, 0.01);
}

// Of many views only the nearest few propose depths. Which ones they are changes on a camera's way, in all
// of the picture at once if their distance to the camera decided, and maps that are off by a step then
// propose others.
TEST(SoftPixel, PicturesDoNotJumpWhereOtherViewsPropose) {
  const auto scene = SoftScene(
      *MakeScene({.viewpoints = CapViewpoints(60, 0.6, 2.0, 0.03), .with_square = true}), {.noise_steps = 1});
  const auto eye_at = [](double t) -> Vector3d {
    return Vector3d(-0.45 + 0.9 * t, 0.25 * std::sin(5 * t), 2.0).normalized() * 2.05;
  };
  const auto nearest_at = [&](double t) {
    const std::vector<int> order = ViewsByDistance(*scene, eye_at(t));
    return std::set<int>(order.begin(), order.begin() + kSoftProposers);
  };
  std::vector<double> changes;  // where another view comes among the nearest
  constexpr int kParts = 200;
  for (int part = 0; part < kParts / 2 && changes.size() < 5; ++part) {
    double before = 1.0 * part / kParts, after = (part + 1.0) / kParts;
    const std::set<int> nearest = nearest_at(before);
    if (nearest == nearest_at(after)) continue;
    for (int halving = 0; halving < 30; ++halving) {
      const double middle = (before + after) / 2;
      (nearest_at(middle) == nearest ? before : after) = middle;
    }
    changes.push_back(before);
  }
  ASSERT_GE(changes.size(), 4u);
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const auto renderer =
        MakeRenderer(scene, {.field = {.kind = FieldKind::kSoft, .soft_width = kWideSoft}, .renderer = kind});
    const auto picture_at = [&](double t) {
      const Rigid3 pose = LookAt(eye_at(t), Vector3d::Zero(), Vector3d::UnitY());
      return Srgb8FromLinear(renderer->Render(CameraModel::Pinhole(96, 72, 80), pose).linear);
    };
    struct Steps {
      double mean = 0, most = 0;  // levels of 255
      int clear = 0;              // by more than eight of them
    } across, beside;
    for (const double change : changes) {
      constexpr double kSmallStep = 2e-5;
      std::vector<cv::Mat> pictures;
      for (const double at : {-1.5, -0.5, 0.5, 1.5}) pictures.push_back(picture_at(change + at * kSmallStep));
      for (std::size_t i = 0; i < 3; ++i) {
        Steps& steps = i == 1 ? across : beside;
        cv::Mat difference;
        cv::absdiff(pictures[i], pictures[i + 1], difference);
        difference = difference.reshape(1);
        double most = 0;
        cv::minMaxLoc(difference, nullptr, &most);
        steps.most = std::max(steps.most, most);
        steps.mean += cv::mean(difference)[0] / (i == 1 ? 1 : 2);
        steps.clear += cv::countNonZero(difference > 8);
      }
    }
    EXPECT_LT(across.mean, 2 * beside.mean);
    EXPECT_LT(across.most, beside.most + 16);
    EXPECT_LE(across.clear, beside.clear + 4);
  }
}

// Where two candidates are believed nearly alike, the renderers' roundings differ: edges of the square.
TEST(SoftPixel, OpenGlEqualsTheReference) {
  struct Case {
    const char* name;
    SceneSpec spec;
    SoftSpec soft;
  };
  const CameraModel camera = CameraModel::Pinhole(96, 72, 80);
  const auto cap = CapViewpoints(60, 0.6, 2.0, 0.03);
  const Case cases[] = {
      {"exact", SquareSpec(), {}},
      {"noise, lies and missing maps", SquareSpec(), {1, 1, 1}},
      {"radial-tangential, gaps",
       {.viewpoints = cap,
        .distortion = Distortion::kRadialTangential,
        .with_square = true,
        .linear_with_gaps = true},
       {}},
      {"fisheye, two sizes",
       {.viewpoints = cap, .distortion = Distortion::kFisheye, .two_sizes = true, .with_square = true},
       {}},
      {"few views", {.viewpoints = CapViewpoints(5, 0.3, 2.0), .with_square = true}, {}}};
  for (const Case& c : cases) {
    const auto plain = MakeScene(c.spec);
    for (const auto& [proxy, scene] :
         {std::pair<std::string, std::shared_ptr<const RenderScene>>{"soft", SoftScene(*plain, c.soft)},
          {"plane", plain},
          {"mesh", WithProxy(*plain, std::make_shared<MeshProxy>(plain->subject, PlaneAndSquare()))}}) {
      const auto gl = MakeRenderer(scene, {.field = kSoft});
      const auto reference = MakeRenderer(scene, {.field = kSoft, .renderer = RendererKind::kReference});
      for (const Rigid3& pose : {Between(), Between(1.2, 0)}) {
        const Rendering fast = gl->Render(camera, pose), exact = reference->Render(camera, pose);
        const Agreement agreement = Compare(fast, exact, cv::Mat::zeros(exact.drawn.size(), CV_8U));
        EXPECT_GE(agreement.within_share, 0.985) << c.name << ", " << proxy;
        EXPECT_LT(agreement.mean_abs, 0.4) << c.name << ", " << proxy;
        EXPECT_NEAR(static_cast<double>(fast.empty_px), static_cast<double>(exact.empty_px), 18)
            << c.name << ", " << proxy;
      }
    }
  }
}

// Photographs that do not fit into graphics memory together: the mean of each pass has its share.
TEST(SoftPixel, DrawingInPassesChangesLittle) {
  const auto scene = SoftSquareScene();
  const auto at_once = MakeRenderer(scene, {.field = kSoft});
  const auto in_passes = MakeRenderer(scene, {.field = kSoft, .gpu_memory_mb = 0.5});
  const Rigid3 pose = Between();
  const cv::Mat a = Srgb8FromLinear(at_once->Render(kPictureCamera, pose).linear),
                b = Srgb8FromLinear(in_passes->Render(kPictureCamera, pose).linear);
  EXPECT_GT(cv::norm(a, b, cv::NORM_INF), 0) << "in passes, indeed";
  EXPECT_GT(cv::PSNR(a, b), 30);
}

TEST(ViewDepthMap, KeepsDepthsToAStep) {
  cv::Mat inverse_depth = cv::Mat::zeros(4, 5, CV_32F);
  inverse_depth.at<float>(1, 2) = 0.5f;
  inverse_depth.at<float>(2, 2) = 0.25f;
  inverse_depth.at<float>(3, 3) = 1e-9f;  // known, and as good as infinitely far
  const ViewDepthMap map = MakeViewDepthMap(CameraModel::Pinhole(5, 4, 4), inverse_depth, 0.01);
  EXPECT_NEAR(map.InverseDepthAt(2, 1), 0.5, 1e-5);
  EXPECT_NEAR(map.InverseDepthAt(2, 2), 0.25, 1e-5);
  EXPECT_GT(map.InverseDepthAt(3, 3), 0);
  EXPECT_EQ(map.InverseDepthAt(0, 0), 0);
}

}  // namespace
}  // namespace ulf::test::soft_pixel_test
