// Tests: core/image/clipped, core/light_field/folder/light_at_points, render/photographs/photograph,
// render/scene/exposure_scales, render/scene/scene.
//
// Views of different exposures: what clips in the long ones, and what is not known of some.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/scene/exposure_scales.h"
#include "tests/render/scenes/agreement.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::clipped_test {
namespace {

using Eigen::Vector3d;

constexpr double kShortS = 0.004;

// Masters of the plane of 16 bits, `exposure_s` of each view; 0.004 s shows light 1 as full scale.
void WriteExposures(const std::filesystem::path& dir, const std::function<double(std::size_t)>& exposure_s) {
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(96, 72, 80);
  auto writer = LightFieldWriter::Create(dir, header);
  const auto viewpoints = test::GridViewpoints(5, 5, 0.2, 2.0);
  for (std::size_t i = 0; i < viewpoints.size(); ++i) {
    View view;
    view.cam_from_world = LookAt(viewpoints[i], Vector3d::Zero(), Vector3d::UnitY());
    Frame frame;
    frame.exposure_s = exposure_s(i);
    frame.image.transfer = Transfer::kLinear;
    test::LightOfPlane(header.camera, view.cam_from_world)
        .convertTo(frame.image.pixels, CV_16U, exposure_s(i) / kShortS * 65535);
    writer.AddView(frame, view);
  }
  writer.SetSubject({Vector3d::Zero(), 0.3});
  writer.Close(1);
}

struct Compared {
  double bright = 0, dark = 0;  // mean difference from the truth where a long exposure clips, and elsewhere
  long undrawn = 0;
};

// `full`: light at which a long exposure clips.
Compared CompareToTruth(const LightField& light_field, RendererKind kind, FieldKind field, bool masks,
                        float full, Rendering* picture = nullptr) {
  const auto scene = LoadScene(light_field, {.form = PhotographForm::kLinear, .masks_clipped = masks});
  const CameraModel camera = CameraModel::Pinhole(96, 72, 90);
  const Rigid3 cam_from_world = LookAt({0.11, 0.07, 2.0}, Vector3d::Zero(), Vector3d::UnitY());
  const Rendering drawn =
      MakeRenderer(scene, {.field = {.kind = field}, .renderer = kind})->Render(camera, cam_from_world);
  const cv::Mat truth = test::LightOfPlane(camera, cam_from_world);
  std::vector<double> exposures;
  for (const View& view : light_field.views) exposures.push_back(view.exposure_s);
  std::ranges::nth_element(exposures, exposures.begin() + 12);
  const double scale = exposures[12] / kShortS;  // of the median view
  Compared result;
  long bright = 0, dark = 0;
  for (int y = 0; y < truth.rows; ++y)
    for (int x = 0; x < truth.cols; ++x) {
      const cv::Vec3f &is = drawn.linear.at<cv::Vec3f>(y, x), &should = truth.at<cv::Vec3f>(y, x);
      const double error = cv::norm(is / scale - should) / std::sqrt(3.0);
      const float most = std::max({should[0], should[1], should[2]});
      (most > 1.3f * full ? result.bright : result.dark) += error;
      ++(most > 1.3f * full ? bright : dark);
      result.undrawn += drawn.drawn.at<std::uint8_t>(y, x) == 0;
    }
  result.bright /= static_cast<double>(std::max(1L, bright));
  result.dark /= static_cast<double>(std::max(1L, dark));
  if (picture) *picture = drawn;
  return result;
}

TEST(Clipped, ShortExposuresReplaceClippedLongOnes) {
  test::ScratchFolder scratch;
  WriteExposures(scratch / "lf", [](std::size_t i) { return i % 2 == 0 ? 4 * kShortS : kShortS; });
  const LightField light_field = ReadLightField(scratch / "lf");
  for (const FieldKind field : {FieldKind::kLinear, FieldKind::kSubdivision, FieldKind::kLumigraph,
                                FieldKind::kLumigraphPerPixel, FieldKind::kSoft}) {
    std::vector<Rendering> of_both(2);
    for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
      const Compared with = CompareToTruth(light_field, kind, field, true, 0.25f,
                                           &of_both[kind == RendererKind::kGl ? 0 : 1]),
                     without = CompareToTruth(light_field, kind, field, false, 0.25f);
      EXPECT_GT(without.bright, 0.06) << FieldName(field);  // or the light does not clip
      EXPECT_LT(with.bright, 0.35 * without.bright) << FieldName(field);
      EXPECT_LT(with.dark, 1.2 * without.dark + 0.002) << FieldName(field);
      EXPECT_EQ(with.undrawn, 0) << FieldName(field);
    }
    cv::Mat difference;
    cv::absdiff(of_both[0].linear, of_both[1].linear, difference);
    EXPECT_LT(cv::mean(difference)[1], 0.01) << FieldName(field);
  }
}

// All views but one, which looks elsewhere, are long: what clips in all of them stays as light as it clips,
// and is no hole.
TEST(Clipped, StaysClippedWhereAllViewsClip) {
  test::ScratchFolder scratch;
  WriteExposures(scratch / "lf", [](std::size_t i) { return i == 0 ? kShortS : 4 * kShortS; });
  LightField light_field = ReadLightField(scratch / "lf");
  light_field.views[0].cam_from_world = LookAt({0, 0, 2}, {0, 0, 4}, Vector3d::UnitY());
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference})
    for (const FieldKind field : {FieldKind::kLinear, FieldKind::kLumigraphPerPixel}) {
      Rendering picture;
      EXPECT_EQ(CompareToTruth(light_field, kind, field, true, 0.25f, &picture).undrawn, 0);
      const cv::Mat truth = test::LightOfPlane(
          CameraModel::Pinhole(96, 72, 90), LookAt({0.11, 0.07, 2.0}, Vector3d::Zero(), Vector3d::UnitY()));
      // At the rim of an area that clips, the view that shows the other side of an edge wins.
      cv::Mat darkest_around;
      cv::erode(truth, darkest_around, cv::Mat::ones(5, 5, CV_8UC1));
      long clipped = 0;
      for (int y = 0; y < truth.rows; ++y)
        for (int x = 0; x < truth.cols; ++x)
          for (int c = 0; c < 3; ++c) {
            const float light = picture.linear.at<cv::Vec3f>(y, x)[c];
            EXPECT_GT(light, truth.at<cv::Vec3f>(y, x)[c] > 0.5f ? 0.4f : -1.0f)
                << x << " " << y << ", " << FieldName(field);
            if (!(darkest_around.at<cv::Vec3f>(y, x)[c] > 0.5f)) continue;
            EXPECT_GT(light, 0.95f) << x << " " << y << ", " << FieldName(field);
            ++clipped;
          }
      EXPECT_GT(clipped, 300);
    }
}

// Of one exposure nothing is masked: photographs are read as they always were.
TEST(Clipped, ViewsOfOneExposureAreLeftAlone) {
  test::ScratchFolder scratch;
  WriteExposures(scratch / "lf", [](std::size_t i) { return (i % 2 == 0 ? 4 : 3.5) * kShortS; });
  const auto scene = LoadScene(ReadLightField(scratch / "lf"), {.form = PhotographForm::kLinear});
  cv::Mat level;
  scene->views[12].photograph->Level(0).convertTo(level, CV_32F);
  double least = 0;
  cv::minMaxLoc(level.reshape(1, static_cast<int>(level.total())).col(3), &least);
  EXPECT_EQ(least, 1);
  const auto counts = scene->store->counts();
  EXPECT_GT(counts.clipped_px, 300u);
  EXPECT_EQ(counts.masked_px, 0u);
  EXPECT_EQ(counts.photographs, 1u);
}

// Counted again from the pyramid's file, where photographs are not decoded.
TEST(Clipped, IsCountedWhetherDecodedOrNot) {
  test::ScratchFolder scratch;
  WriteExposures(scratch / "lf", [](std::size_t i) { return i % 2 == 0 ? 4 * kShortS : kShortS; });
  const LightField light_field = ReadLightField(scratch / "lf");
  cv::Mat clipped;
  ReadViewLight(light_field, light_field.views[12], &clipped);
  const auto truth = static_cast<std::uint64_t>(cv::countNonZero(clipped));
  EXPECT_GT(truth, 300u);
  for (int time = 0; time < 2; ++time) {
    const auto scene = LoadScene(light_field, {.form = PhotographForm::kLinear});
    scene->views[12].photograph->Level(0);
    scene->views[12].photograph->Level(1);
    const auto counts = scene->store->counts();
    EXPECT_EQ(counts.decoded, time == 0 ? 1u : 0u);
    EXPECT_EQ(counts.clipped_px, truth);
    EXPECT_EQ(counts.masked_px, truth);
  }
}

// A highlight of one pixel is as bright in a small picture as it would be without a mask.
TEST(Clipped, KeepsItsLightInCoarserLevels) {
  cv::Mat light(16, 16, CV_32FC3, cv::Scalar::all(0.1)), clipped = cv::Mat::zeros(16, 16, CV_8UC1);
  light.at<cv::Vec3f>(5, 6) = {1, 1, 1};
  clipped.at<std::uint8_t>(5, 6) = 255;
  const ViewPyramid plain = MakeLinearPyramid(light), masked = MakeLinearPyramid(light, {}, clipped);
  for (const int level : {0, 1, 2, 4}) {
    cv::Mat a, b;
    plain[static_cast<std::size_t>(level)].convertTo(a, CV_32F);
    masked[static_cast<std::size_t>(level)].convertTo(b, CV_32F);
    const cv::Vec4f &p = a.at<cv::Vec4f>(5 >> level, 6 >> level),
                    &q = b.at<cv::Vec4f>(5 >> level, 6 >> level);
    EXPECT_NEAR(q[0] / q[3], p[0], 2e-3 * p[0]) << level;
    EXPECT_NEAR(q[3], 1 - (1 - kShareOfClipped) / static_cast<float>(1 << (2 * level)), 1e-3) << level;
  }
}

// ---- Exposures that are not known ----

// Points of the plane with the places where all views show them.
void AddPoints(LightField& light_field) {
  for (ScenePoint& point : light_field.points = test::PointsOfPlaneAndSquare(120, 0)) {
    point.position_in_world *= 0.3;
    for (const View& view : light_field.views)
      if (const auto img =
              light_field.CameraOf(view).ImgFromCam(view.cam_from_world * point.position_in_world);
          img && light_field.CameraOf(view).Contains(*img))
        point.track.push_back({view.id, *img});
  }
}

TEST(Exposures, OneThatIsNotKnownIsFoundByTheOthers) {
  test::ScratchFolder scratch;
  const auto exposure_of = [](std::size_t i) {
    return (i % 3 == 0 ? 0.5 : i % 3 == 1 ? 0.7 : 1.0) * kShortS;
  };
  WriteExposures(scratch / "lf", exposure_of);
  LightField light_field = ReadLightField(scratch / "lf");
  AddPoints(light_field);
  const std::vector<float> truth = ScalesOf(light_field).scales;
  EXPECT_TRUE(ScalesOf(light_field).estimated.empty());
  EXPECT_GT(truth[0] / truth[2], 1.9);
  for (const std::size_t unknown : {0u, 7u, 23u}) {
    LightField without = light_field;
    without.views[unknown].exposure_s = 0;
    const ExposureScales found = ScalesOf(without);
    EXPECT_THAT(found.estimated, testing::ElementsAre(without.views[unknown].id));
    EXPECT_TRUE(found.unmatched.empty());
    for (std::size_t i = 0; i < truth.size(); ++i)
      EXPECT_NEAR(found.scales[i], truth[i], 0.03 * truth[i]) << "view " << i << " of unknown " << unknown;
  }
  // Without shared points that view alone stays as it is.
  light_field.points.clear();
  light_field.views[6].exposure_s = 0;
  const ExposureScales alone = ScalesOf(light_field);
  EXPECT_THAT(alone.unmatched, testing::ElementsAre(light_field.views[6].id));
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(alone.scales[i], i == 6 ? 1.0f : truth[i], 1e-5) << i;
}

// Where apertures are told, a view without one is of unknown exposure, too.
TEST(Exposures, UnknownApertureMakesAnExposureUnknown) {
  test::ScratchFolder scratch;
  WriteExposures(scratch / "lf", [](std::size_t) { return 0.5 * kShortS; });
  LightField light_field = ReadLightField(scratch / "lf");
  AddPoints(light_field);
  for (View& view : light_field.views) view.f_number = 8;
  light_field.views[4].f_number.reset();
  const ExposureScales found = ScalesOf(light_field);
  EXPECT_THAT(found.estimated, testing::ElementsAre(light_field.views[4].id));
  for (const float scale : found.scales) EXPECT_NEAR(scale, 1, 0.02);
}

// What a passer-by covers half of gives no exposure that could be trusted.
TEST(Exposures, PointsThatContradictEachOtherGiveNone) {
  test::ScratchFolder scratch;
  WriteExposures(scratch / "lf", [](std::size_t) { return 0.5 * kShortS; });
  LightField light_field = ReadLightField(scratch / "lf");
  AddPoints(light_field);
  View& view = light_field.views[8];
  cv::RNG random(2);
  cv::Mat noise(72, 96, CV_8UC3);
  random.fill(noise, cv::RNG::UNIFORM, 40, 240);
  cv::Mat coarse;
  cv::resize(noise(cv::Rect(0, 0, 12, 9)), coarse, noise.size(), 0, 0, cv::INTER_NEAREST);
  cv::imwrite((light_field.root / view.image_path).string(), coarse);
  std::filesystem::remove(light_field.root / view.master_path);
  view.exposure_s = 0;
  const ExposureScales found = ScalesOf(light_field);
  EXPECT_THAT(found.unmatched, testing::ElementsAre(view.id));
}

}  // namespace
}  // namespace ulf::clipped_test
