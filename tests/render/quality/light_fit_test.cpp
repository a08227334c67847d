// Tests: render/quality/light_fit, render/quality/light_samples, render/quality/light_solution,
// render/scene/scene.
#include "render/quality/light_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/at.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/quality/evaluate.h"
#include "tests/render/scenes/agreement.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_run.h"

namespace ulf::light_fit_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::SceneSpec;

// Log gains B G R of views, each channel's with a mean of 0.
std::vector<cv::Vec3f> Gains(std::size_t views, double spread, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, spread), of_channel(0, 0.2 * spread);
  std::vector<cv::Vec3d> logs;
  cv::Vec3d mean(0, 0, 0);
  for (std::size_t i = 0; i < views; ++i) {
    const double all = normal(random);
    logs.emplace_back(all + of_channel(random), all + of_channel(random), all + of_channel(random));
    mean += logs.back() / static_cast<double>(views);
  }
  std::vector<cv::Vec3f> gains;
  for (const cv::Vec3d& log : logs) {
    cv::Vec3f& gain = gains.emplace_back();
    for (int c = 0; c < 3; ++c) gain[c] = static_cast<float>(std::exp(log[c] - mean[c]));
  }
  return gains;
}

SceneSpec CapOf(int views, int width = 160) {
  return {.viewpoints = test::CapViewpoints(views, 0.5, 2.0, 0.03),
          .width = width,
          .height = width * 3 / 4,
          .focal_px = width / 1.2,
          .with_square = true};
}

using Paint = std::function<void(int view, cv::Mat& light)>;

// The plane and the square as a view sees them, kept for the views of all tests.
const cv::Mat& LightSeenBy(const SceneView& view) {
  using Key = std::tuple<int, int, double, double, double>;
  static std::map<Key, cv::Mat> kept;
  const Vector3d& center = view.center_in_world;
  cv::Mat& light = kept[{view.camera.width, view.camera.height, center.x(), center.y(), center.z()}];
  if (light.empty()) light = test::LightOfPlane(view.camera, view.cam_from_world, true);
  return light;
}

// Photographs of the plane and the square by cameras of these corrections, over their true mesh.
std::shared_ptr<const RenderScene> Photographed(const SceneSpec& spec,
                                                const std::vector<LightCorrection>& corrections,
                                                const Paint& paint = {}) {
  const auto scene = test::MakeScene(spec);
  for (std::size_t i = 0; i < scene->views.size(); ++i) {
    SceneView& view = scene->views[i];
    cv::Mat light = 0.8 * LightSeenBy(view);
    if (paint) paint(static_cast<int>(i), light);
    for (int y = 0; y < light.rows; ++y)
      for (int x = 0; x < light.cols; ++x)
        light.at<cv::Vec3f>(y, x) = light.at<cv::Vec3f>(y, x).mul(corrections[i].gain) *
                                    corrections[i].Falloff(view.camera, Vector2d(x + 0.5, y + 0.5));
    view.photograph = test::HoldPhotograph(MakePyramid(Srgb8FromLinear(light)));
  }
  return WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, test::PlaneAndSquare()));
}

std::vector<LightCorrection> Corrections(const std::vector<cv::Vec3f>& gains, float r2, float r4) {
  std::vector<LightCorrection> corrections;
  for (const cv::Vec3f& gain : gains) corrections.push_back({gain, r2, r4});
  return corrections;
}

// The largest share by which what was found is off, of all views, channels and places between
// axis and corner.
double Off(const RenderScene& scene, const LightFit& fit, const std::vector<LightCorrection>& truth) {
  const auto fitted = WithLight(scene, fit);
  double off = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SceneView& view = fitted->views[i];
    for (const double share : {0.0, 0.5, 0.95}) {
      const Vector2d img(view.camera.cx * (1 - share) + 0.01, view.camera.cy * (1 - share) + 0.01);
      for (int c = 0; c < 3; ++c) {
        const double found = view.correction.gain[c] * view.correction.Falloff(view.camera, img);
        off = std::max(off, std::abs(found / (truth[i].gain[c] * truth[i].Falloff(view.camera, img)) - 1));
      }
    }
  }
  return off;
}

TEST(LightFit, FindsGainsAndFalloffWithinAHundredth) {
  for (const unsigned seed : test::SeedsOf({1, 2}))
    for (const double spread : {0.05, 0.3}) {
      const SceneSpec spec = CapOf(16);
      const auto gains_only = Corrections(Gains(16, spread, seed), 0, 0);
      const auto scene = Photographed(spec, gains_only);
      const LightFit fit = FitLight(*scene);
      EXPECT_EQ(fit.model, LightModel::kGains) << spread << ", seed " << seed;
      EXPECT_LT(Off(*scene, fit, gains_only), 0.01) << spread << ", seed " << seed;

      const auto both = Corrections(Gains(16, spread, seed), -0.45f, 0.1f);
      const auto darker = Photographed(spec, both);
      const LightFit with_falloff = FitLight(*darker);
      EXPECT_EQ(with_falloff.model, LightModel::kGainsAndFalloff) << spread << ", seed " << seed;
      EXPECT_LT(Off(*darker, with_falloff, both), 0.01) << spread << ", seed " << seed;
      EXPECT_NEAR(with_falloff.corner_stops, -std::log2(1 - 0.45 + 0.1), 0.03);
    }
}

TEST(LightFit, EveryCameraHasItsOwnFalloff) {
  SceneSpec spec = CapOf(18);
  spec.two_sizes = true;
  auto truth = Corrections(Gains(18, 0.1, 4), -0.3f, 0);
  for (std::size_t i = 2; i < truth.size(); i += 3) truth[i].falloff_r2 = -0.1f;
  const auto scene = Photographed(spec, truth);
  const LightFit fit = FitLight(*scene);
  EXPECT_EQ(fit.falloffs.size(), 2);
  EXPECT_LT(Off(*scene, fit, truth), 0.015);
}

TEST(LightFit, EqualLightStaysExactlyAsItIs) {
  for (const bool gaps : {false, true}) {
    SceneSpec spec = CapOf(16);
    spec.linear_with_gaps = gaps;
    const auto made = test::MakeScene(spec);
    const auto scene = WithProxy(*made, std::make_shared<MeshProxy>(made->subject, test::PlaneAndSquare()));
    const LightFit fit = FitLight(*scene);
    EXPECT_EQ(fit.model, LightModel::kAsRecorded) << ToText(fit.explained);
    EXPECT_GT(fit.points, 500);
    const auto with_light = WithLight(*scene, fit);
    for (const SceneView& view : with_light->views) EXPECT_EQ(view.correction, LightCorrection{});
  }
}

TEST(LightFit, EmptyProxyLeavesLightAsRecorded) {
  const auto scene = test::MakeScene(CapOf(8));
  const LightFit fit = FitLight(*scene);
  EXPECT_EQ(fit.model, LightModel::kAsRecorded);
  EXPECT_EQ(fit.points, 0);
}

// A light that goes along with the camera, and a fifth of all points random in every view.
TEST(LightFit, HighlightsAndWrongPointsDoNotMoveIt) {
  const auto truth = Corrections(Gains(16, 0.2, 5), -0.3f, 0);
  const auto scene = Photographed(CapOf(16), truth, [](int view, cv::Mat& light) {
    cv::RNG random(static_cast<std::uint64_t>(view) + 7);
    for (int y = 0; y < light.rows; y += 8)
      for (int x = 0; x < light.cols; x += 8)
        if (random.uniform(0.0, 1.0) < 0.1)
          light(cv::Rect(x, y, 8, 8) & cv::Rect({}, light.size())) =
              cv::Scalar(random.uniform(0.0, 0.9), random.uniform(0.0, 0.9), random.uniform(0.0, 0.9));
    light(cv::Rect(60 + 2 * view, 47, 20, 20)) += cv::Scalar::all(0.3);
  });
  const LightFit fit = FitLight(*scene);
  EXPECT_EQ(fit.model, LightModel::kGainsAndFalloff);
  EXPECT_LT(Off(*scene, fit, truth), 0.01);
}

TEST(LightFit, AFifthOfWrongPointsDoesNotMoveTheSolution) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    constexpr int kViews = 12;
    const std::vector<cv::Vec3f> gains = Gains(kViews, 0.3, seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.02);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<LightSample> samples;
    for (int p = 0; p < 3000; ++p) {
      LightSample sample{.channel = p % 3, .held_out = false, .seen = {}};
      const bool is_wrong = share(random) < 0.2;
      const double light = std::log(0.05 + 0.5 * share(random));
      for (int i = 0; i < 6; ++i) {
        const int view = (p / 3 + i * (1 + p % 2)) % kViews;
        const double r2 = share(random);
        // What is wrong is mostly too bright, and more so in the first views.
        const double wrong = is_wrong ? (view < 4 ? 1.5 : 0.5) * share(random) : 0;
        sample.seen.push_back({view, 0, r2,
                               light + wrong + noise(random) +
                                   std::log(gains[At(view)][sample.channel] * (1 - 0.4 * r2 + 0.1 * r2 * r2)),
                               0.02});
      }
      samples.push_back(sample);
    }
    const LightSolution found = SolveLight(samples, kViews, 1, LightModel::kGainsAndFalloff);
    for (int view = 0; view < kViews; ++view)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(std::exp(found.log_gain[At(c)][At(view)]) / gains[At(view)][c], 1, 0.01)
            << "view " << view << ", channel " << c << ", seed " << seed;
    for (const double r2 : {0.3, 0.6, 1.0})
      EXPECT_NEAR(1 + found.falloff[0][0] * r2 + found.falloff[0][1] * r2 * r2, 1 - 0.4 * r2 + 0.1 * r2 * r2,
                  0.01)
          << "seed " << seed;
  }
}

TEST(LightFit, BothRenderersTakeItOutInTheSameWay) {
  const CameraModel camera = CameraModel::Pinhole(96, 72, 108);
  struct Case {
    Distortion distortion;
    bool two_sizes, gaps;
  };
  for (const auto& [distortion, two_sizes, gaps] : {Case{Distortion::kNone, false, false},
                                                    {Distortion::kNone, true, true},
                                                    {Distortion::kRadialTangential, true, false},
                                                    {Distortion::kFisheye, false, true}}) {
    const SceneSpec spec{.viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03),
                         .distortion = distortion,
                         .two_sizes = two_sizes,
                         .with_square = true,
                         .linear_with_gaps = gaps};
    const auto made = test::MakeScene(spec);
    const auto gains = Gains(made->views.size(), 0.3, 3);
    for (std::size_t i = 0; i < made->views.size(); ++i) {
      made->views[i].black = 0.01f;
      made->views[i].scale = i % 2 ? 0.8f : 1.1f;
      made->views[i].correction = {gains[i], -0.4f - 0.1f * static_cast<float>(i % 3), 0.15f};
    }
    const auto scene = WithProxy(*made, std::make_shared<MeshProxy>(made->subject, test::PlaneAndSquare()));
    const auto gl = MakeRenderer(scene, {.renderer = RendererKind::kGl});
    const auto reference = MakeRenderer(scene, {.renderer = RendererKind::kReference});
    for (const FieldKind kind : {FieldKind::kSubdivision, FieldKind::kLumigraph,
                                 FieldKind::kLumigraphPerPixel, FieldKind::kNearest}) {
      gl->SetField({.kind = kind});
      reference->SetField({.kind = kind});
      const Rigid3 pose = LookAt({0.2, 0.1, 2.1}, Vector3d::Zero(), Vector3d::UnitY());
      const Rendering fast = gl->Render(camera, pose), plain = reference->Render(camera, pose);
      const cv::Mat band = test::VisibilityBand(*scene, {.field = reference->field()}, camera, pose);
      const test::Agreement agreement = test::Compare(fast, plain, band);
      const std::string name = fmt::format("{}, distortion {}, two sizes {}, gaps {}", FieldName(kind),
                                           static_cast<int>(distortion), two_sizes, gaps);
      EXPECT_GE(agreement.within_share, 0.999) << name;
      EXPECT_GE(agreement.within_share_of_all, 0.98) << name;
    }
  }
}

// What the corrections say is what is rendered: the same light from photographs that have none.
TEST(LightFit, CorrectedPhotographsShowTheCommonScale) {
  const auto truth = Corrections(Gains(30, 0.25, 6), -0.35f, 0.05f);
  const SceneSpec spec = CapOf(30);
  const auto even = Photographed(spec, std::vector<LightCorrection>(30));
  const auto scrambled = Photographed(spec, truth);
  const auto evened = WithLight(*scrambled, FitLight(*scrambled));
  const CameraModel camera = CameraModel::Pinhole(160, 120, 200);
  const Rigid3 pose = LookAt({0.1, 0.05, 2.0}, Vector3d::Zero(), Vector3d::UnitY());
  const auto render = [&](const std::shared_ptr<const RenderScene>& scene) {
    return MakeRenderer(scene, {.renderer = RendererKind::kReference})->Render(camera, pose).linear;
  };
  const cv::Mat wanted = render(even);
  const auto rms = [&](const cv::Mat& linear) {
    return cv::norm(linear, wanted, cv::NORM_L2) / std::sqrt(3.0 * static_cast<double>(wanted.total()));
  };
  EXPECT_LT(rms(render(evened)), 0.006);
  EXPECT_GT(rms(render(scrambled)), 0.03);
}

TEST(LightFit, LeftOutViewsAreShownBetterThanWithoutIt) {
  constexpr int kViews = 24;
  auto gains = Gains(kViews, 0.25, 8);
  std::vector<int> left_out;
  for (int i = 0; i < kViews; i += 8) left_out.push_back(i);
  for (const int i : left_out) gains[At(i)] = cv::Vec3f::all(1);
  const auto scene = Photographed(CapOf(kViews, 240), Corrections(gains, -0.3f, 0));
  const auto given = Without(*scene, left_out);
  const LightFit fit = FitLight(*given);
  ASSERT_EQ(fit.model, LightModel::kGainsAndFalloff);
  const EvaluateOptions options{.left_out = left_out, .fields = {{.kind = FieldKind::kSubdivision}}};
  const double without = Evaluate(*scene, options).results.front().all.psnr_db;
  const double with = Evaluate(*WithLight(*scene, fit), options).results.front().all.psnr_db;
  EXPECT_GT(with, without + 3) << without << " dB without";
  RecordProperty("without_db", std::to_string(without));
  RecordProperty("with_db", std::to_string(with));
}

// A left-out view's own exposure is never looked at: it is that of its neighbours where these tell it,
// else the mean.
TEST(LightFit, UnfittedViewTakesItsNeighboursExposure) {
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(7, 7, 0.2, 2.0)});
  LightFit smooth{.model = LightModel::kGains}, random = smooth;
  const auto gains = Gains(scene->views.size(), 0.3, 9);
  const auto truth = [&](std::size_t i) {
    return static_cast<float>(std::exp(0.5 * scene->views[i].center_in_world.x()));
  };
  constexpr std::size_t kLeftOut = 23;
  for (std::size_t i = 0; i < scene->views.size(); ++i) {
    if (i == kLeftOut) continue;
    smooth.gains[scene->views[i].id] = cv::Vec3f::all(truth(i));
    random.gains[scene->views[i].id] = gains[i];
  }
  EXPECT_NEAR(WithLight(*scene, smooth)->views[kLeftOut].correction.gain[0], truth(kLeftOut), 0.01);
  EXPECT_EQ(WithLight(*scene, random)->views[kLeftOut].correction, LightCorrection{});
}

}  // namespace
}  // namespace ulf::light_fit_test
