// Tests: render/gl/gl_renderer, render/renderer/reference_renderer.
//
// OpenGL against the reference on light fields that nobody thought of: few views and many, on caps, rings,
// spheres, grids, lines, in two clusters back to back and in one place, at lopsided distances, in millimetres
// and kilometres, with holes in their photographs and exposures of their own, by lenses that fold what lies
// beside the picture, over planes, points and meshes, seen from anywhere, with narrow apertures and wide
// ones.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <tuple>

#include "render/fields/field_options.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "render/renderer/renderer.h"
#include "tests/render/scenes/agreement.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test::random_scenes_test {
namespace {

using Eigen::Vector3d;

const CameraModel kCamera = CameraModel::Pinhole(96, 72, 110);

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int Of(int sides) { return std::uniform_int_distribution<int>(0, sides - 1)(random_); }
  Vector3d Direction() {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
  }

 private:
  std::mt19937 random_;
};

struct RandomViews {
  std::string shape;
  std::vector<Vector3d> viewpoints;
};

RandomViews Viewpoints(Dice& dice) {
  const int count = static_cast<int>(3 * std::pow(400.0 / 3, dice.Between(0, 1)));
  const double lopsided = dice.Of(2) == 0 ? 0 : dice.Between(0, 0.6);
  const auto seed = static_cast<unsigned>(dice.Of(1000));
  const double angle = dice.Between(0.1, 1.4);
  switch (dice.Of(7)) {
    case 0:
      return {"ring", RingViewpoints(count, dice.Between(0, 1.2), 2, 0.05 * lopsided, seed)};
    case 1:
      return {"sphere", CapViewpoints(count, M_PI, 2, lopsided, seed)};
    case 2:
      return {"grid", GridViewpoints(1 + count / 8, 8, 0.15, 2)};
    case 3:
      return {"line", GridViewpoints(count, 1, 2.0 / count, 2)};
    case 4: {
      std::vector<Vector3d> both = CapViewpoints((count + 1) / 2, 0.3, 2, lopsided, seed);
      for (std::size_t i = 0, half = both.size(); i < half; ++i) both.push_back(-both[i]);
      return {"two clusters back to back", both};
    }
    case 5:
      return {"one place", std::vector<Vector3d>(static_cast<std::size_t>(count), Vector3d(0.3, 0.2, 2))};
    default:
      return {"cap", CapViewpoints(count, angle, 2, lopsided, seed)};
  }
}

FieldOptions Field(Dice& dice) {
  switch (dice.Of(5)) {
    case 0:
      return {.kind = FieldKind::kLinear};
    case 4:
      return {.kind = FieldKind::kLumigraph, .lumigraph_k = 2 + dice.Of(7), .lumigraph_triangles = 400};
    case 1:
      return {.kind = FieldKind::kLumigraphPerPixel, .lumigraph_k = 2 + dice.Of(7)};
    case 2:
      return {.kind = FieldKind::kNearest};
    default:
      return {.kind = FieldKind::kSubdivision, .level = 1 + dice.Of(4)};
  }
}

// Near some view's direction, or anywhere; from close to the subject to far behind the views.
Rigid3 Pose(const std::vector<Vector3d>& viewpoints, Dice& dice) {
  const Vector3d& some = viewpoints[static_cast<std::size_t>(dice.Of(static_cast<int>(viewpoints.size())))];
  const Vector3d direction =
      dice.Of(4) == 0 ? dice.Direction() : (some.normalized() + 0.2 * dice.Direction()).normalized();
  const Vector3d up = std::abs(direction.y()) > 0.95 ? Vector3d::UnitX() : Vector3d::UnitY();
  Vector3d center = dice.Between(0.5, 4) * direction;
  if (std::abs(center.z()) < 0.05) center.z() = 0.05;  // not in the surface itself
  return LookAt(center, 0.1 * dice.Direction(), up);
}

struct RandomScene {
  std::string name;
  double unit = 1;
  std::shared_ptr<const RenderScene> scene;
};

RandomScene Scene(const RandomViews& views, Dice& dice) {
  SceneSpec spec;
  spec.viewpoints = views.viewpoints;
  spec.width = 64, spec.height = 48, spec.focal_px = 55;
  constexpr Distortion kDistortions[] = {Distortion::kNone, Distortion::kRadialTangential,
                                         Distortion::kFisheye};
  spec.distortion = kDistortions[dice.Of(3)];
  spec.folds = dice.Of(2) == 0;
  spec.two_sizes = dice.Of(3) == 0;
  spec.linear_with_gaps = dice.Of(4) == 0;
  spec.unit = std::pow(10, dice.Between(-3, 3));
  const int proxy = dice.Of(5);
  spec.with_square = proxy < 3;
  const auto scene = MakeScene(spec);
  const bool exposures_differ = dice.Of(4) == 0;
  if (exposures_differ)
    for (SceneView& view : scene->views) {
      view.black = static_cast<float>(dice.Between(0, 0.02));
      view.scale = static_cast<float>(std::exp2(dice.Between(-1, 1)));
    }
  RandomScene made{views.shape + " of " + std::to_string(views.viewpoints.size()), spec.unit, scene};
  const Subject& subject = made.scene->subject;
  if (proxy < 2)
    made.scene = WithProxy(*made.scene, std::make_shared<MeshProxy>(subject, PlaneAndSquare(spec.unit)));
  if (proxy == 2)
    made.scene = WithProxy(
        *made.scene, std::make_shared<PointsProxy>(subject, PointsOfPlaneAndSquare(600, 30, spec.unit)));
  made.name += ", " + made.scene->proxy->Name() + ", unit " + std::to_string(spec.unit) +
               (spec.two_sizes ? ", two sizes" : "") + (spec.linear_with_gaps ? ", gaps" : "") +
               (exposures_differ ? ", exposures" : "");
  return made;
}

std::optional<Aperture> RandomAperture(const RandomScene& random, Dice& dice) {
  if (dice.Of(4) > 0) return std::nullopt;
  return Aperture{.radius = random.unit * dice.Between(0, 0.5),
                  .focus_in_world = random.unit * dice.Between(0, 0.5) * dice.Direction()};
}

class RandomScenes : public ::testing::TestWithParam<unsigned> {};

TEST_P(RandomScenes, OpenGlEqualsTheReference) {
  Dice dice(GetParam());
  const RandomViews views = Viewpoints(dice);
  const RandomScene random = Scene(views, dice);
  const auto gl = MakeRenderer(random.scene, {.renderer = RendererKind::kGl});
  const auto reference = MakeRenderer(random.scene, {.renderer = RendererKind::kReference});
  constexpr int kPictures = 4;
  // A GPU takes the weights of texels to a 256th, and rasterises shadow maps its own way.
  static const bool on_gpu = !GlContext().IsSoftware();
  const double least_within = on_gpu ? 0.998 : 0.999, least_as_sure = on_gpu ? 0.99 : 0.999;
  constexpr double kFewPx = 7;          // a thousandth
  constexpr double kLeastOfAll = 0.99;  // band included
  double compared = 0;
  for (int i = 0; i < kPictures; ++i) {
    const FieldOptions field = Field(dice);
    const std::optional<Aperture> aperture = RandomAperture(random, dice);
    Rigid3 pose = Pose(views.viewpoints, dice);
    pose.translation *= random.unit;
    for (const auto& renderer : {gl.get(), reference.get()}) {
      renderer->SetField(field);
      renderer->SetAperture(aperture);
    }
    ASSERT_EQ(gl->field(), reference->field());
    const Rendering fast = gl->Render(kCamera, pose), plain = reference->Render(kCamera, pose);
    const Agreement agreement = Compare(
        fast, plain,
        VisibilityBand(*random.scene, {.field = reference->field(), .aperture = aperture}, kCamera, pose));
    const double band_px = agreement.band_share * static_cast<double>(fast.linear.total());
    for (const auto& [name, share, least] :
         {std::tuple{"within two levels", agreement.within_share, least_within},
          {"as sure and drawn", agreement.confidence_share, least_as_sure}})
      EXPECT_GE(share, least) << name << ": " << random.name << ", " << FieldName(gl->field().kind) << " "
                              << gl->field().level
                              << (aperture ? ", aperture " + std::to_string(aperture->radius / random.unit)
                                           : "")
                              << ", from " << pose.OriginInSource().transpose() / random.unit << ", band "
                              << agreement.band_share;
    EXPECT_LE(std::abs(fast.filled_px - plain.filled_px), band_px + kFewPx) << random.name;
    EXPECT_LE(std::abs(fast.empty_px - plain.empty_px), band_px + kFewPx) << random.name;
    EXPECT_GE(agreement.within_share_of_all, kLeastOfAll) << random.name << ", band " << agreement.band_share;
    compared += (1 - agreement.band_share) / kPictures;
  }
  EXPECT_GT(compared, 0.4) << random.name << ": hardly anything is compared";
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomScenes, ::testing::Range(1u, 1u + SEEDS));

}  // namespace
}  // namespace ulf::test::random_scenes_test
