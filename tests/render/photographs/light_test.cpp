// Tests: render/photographs/photograph, render/photographs/photograph_store.
//
// Light beyond 8 bits, from photographs to renderings: EXR, masters, pixels without light.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/quality/evaluate.h"
#include "render/renderer/renderer.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::light_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Ten stops across the picture, 1/32 to 32 times the plane's light.
cv::Mat TenStops(const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat light = test::LightOfPlane(camera, cam_from_world);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x)
      light.at<cv::Vec3f>(y, x) *= std::exp2(10.0f * (static_cast<float>(x) + 0.5f) / light.cols - 5);
  return light;
}

float Brightest(const cv::Mat& light) {
  double most = 0;
  cv::minMaxLoc(light.reshape(1), nullptr, &most);
  return static_cast<float>(most);
}

// Share of the pixels that differ by more than `tolerance` of their value.
double ShareBeyond(const cv::Mat& a, const cv::Mat& b, float tolerance) {
  long beyond = 0;
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        const float p = a.at<cv::Vec3f>(y, x)[c], q = b.at<cv::Vec3f>(y, x)[c];
        beyond += !(std::abs(p - q) <= tolerance * std::max(std::abs(p), std::abs(q)));
      }
  return static_cast<double>(beyond) / static_cast<double>(3 * a.total());
}

TEST(Light, TenStopsComeBackFromAPhotographsOwnPlace) {
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(5, 5, 0.2, 2.0)});
  for (SceneView& view : scene->views)
    view.photograph = test::HoldPhotograph(MakeLinearPyramid(TenStops(view.camera, view.cam_from_world)));
  const SceneView& view = scene->views[12];
  const cv::Mat photograph = TenStops(view.camera, view.cam_from_world);
  ASSERT_GT(Brightest(photograph), 20);
  std::vector<Rendering> pictures;
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const auto renderer =
        MakeRenderer(scene, {.field = {.kind = FieldKind::kLinear}, .renderer = kind, .fill = true});
    const Rendering own = renderer->Render(view.camera, view.cam_from_world);
    EXPECT_LT(ShareBeyond(own.linear, photograph, 0.01f), 0.01) << renderer->Name();
    pictures.push_back(renderer->Render(CameraModel::Pinhole(80, 60, 90),
                                        LookAt({0.13, 0.07, 1.9}, Vector3d::Zero(), Vector3d::UnitY())));
  }
  EXPECT_LT(ShareBeyond(pictures[0].linear, pictures[1].linear, 0.01f), 0.01);
}

TEST(Light, PyramidAveragesLightWithoutNonFiniteValues) {
  cv::Mat light(4, 4, CV_32FC3, cv::Scalar::all(0.5));
  light.at<cv::Vec3f>(0, 0) = {kNan, 1, 1};
  light.at<cv::Vec3f>(1, 0) = {1, kInfinity, 1};
  light.at<cv::Vec3f>(0, 1) = {200, 100, 50};
  light.at<cv::Vec3f>(1, 1) = {1e9f, 0, 0};  // beyond halves
  const ViewPyramid pyramid = MakeLinearPyramid(light);
  ASSERT_EQ(pyramid.size(), 3u);
  using Half4 = cv::Vec<cv::float16_t, 4>;
  EXPECT_EQ(float(pyramid[0].at<Half4>(0, 0)[3]), 0);
  EXPECT_EQ(float(pyramid[0].at<Half4>(0, 0)[1]), 0);
  EXPECT_EQ(float(pyramid[0].at<Half4>(1, 1)[0]), 65504);
  EXPECT_EQ(float(pyramid[1].at<Half4>(0, 0)[3]), 0.5f);
  EXPECT_EQ(float(pyramid[1].at<Half4>(0, 0)[1]), 25);  // times its share
  EXPECT_EQ(float(pyramid[1].at<Half4>(1, 1)[2]), 0.5f);
  EXPECT_NEAR(float(pyramid[2].at<Half4>(0, 0)[3]), 14.0 / 16, 1e-3);
}

TEST(Light, PixelsWithoutLightHaveNoWeight) {
  const auto make = [](bool with_gap) {
    auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(5, 5, 0.2, 2.0)});
    for (std::size_t i = 0; i < scene->views.size(); ++i) {
      SceneView& view = scene->views[i];
      cv::Mat light = test::LightOfPlane(view.camera, view.cam_from_world);
      if (with_gap && i == 12) light(cv::Rect(40, 30, 16, 12)) = cv::Scalar(kNan, kInfinity, -kInfinity);
      view.photograph = test::HoldPhotograph(MakeLinearPyramid(light));
    }
    return scene;
  };
  const auto whole = make(false), with_gap = make(true);
  const SceneView& view = whole->views[12];
  for (const FieldKind field : {FieldKind::kLinear, FieldKind::kLumigraphPerPixel, FieldKind::kNearest}) {
    std::vector<Rendering> of_both;
    for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
      const RenderOptions options{.field = {.kind = field}, .renderer = kind};
      const Rendering picture = MakeRenderer(with_gap, options)->Render(view.camera, view.cam_from_world);
      EXPECT_TRUE(cv::checkRange(picture.linear)) << FieldName(field);
      EXPECT_EQ(picture.empty_px, 0);
      // What the gap's neighbours see there is nearly the same: the scene is nearly the proxy.
      const Rendering truth = MakeRenderer(whole, options)->Render(view.camera, view.cam_from_world);
      cv::Mat difference;
      cv::absdiff(picture.linear, truth.linear, difference);
      EXPECT_LT(cv::mean(difference(cv::Rect(38, 28, 20, 16)))[1], 0.06) << FieldName(field);
      cv::absdiff(picture.linear(cv::Rect(0, 0, 30, 72)), truth.linear(cv::Rect(0, 0, 30, 72)), difference);
      EXPECT_LT(cv::mean(difference)[1], 1e-3) << FieldName(field);
      of_both.push_back(picture);
    }
    EXPECT_LT(ShareBeyond(of_both[0].linear, of_both[1].linear, 0.02f), 0.02) << FieldName(field);
  }
}

// ---- Files ----

// A set as nerfstudio has it, with EXR photographs of a 4 x 3 grid; a few pixels of the first are not finite.
void WriteExrSet(const std::filesystem::path& dir) {
  std::filesystem::create_directories(dir / "images");
  const CameraModel camera = CameraModel::Pinhole(96, 72, 80);
  nlohmann::json frames = nlohmann::json::array();
  for (const Vector3d& viewpoint : test::GridViewpoints(4, 3, 0.2, 2.0)) {
    const Rigid3 cam_from_world = LookAt(viewpoint, Vector3d::Zero(), Vector3d::UnitY());
    cv::Mat light = TenStops(camera, cam_from_world);
    if (frames.empty()) {
      light.at<cv::Vec3f>(5, 5) = {kNan, 0, 0};
      light.at<cv::Vec3f>(6, 5) = {0, kInfinity, 0};
      light.at<cv::Vec3f>(7, 5) = {0, 0, -kInfinity};
    }
    const std::string name = fmt::format("images/{}.exr", frames.size());
    WriteFileAtomically(dir / name,
                        ExrBytes({{"R", light, 2}, {"G", light, 1}, {"B", light, 0}}, ExrCompression::kPiz));
    Eigen::Matrix4d matrix = cam_from_world.Inverse().Matrix();
    matrix.col(1) *= -1;
    matrix.col(2) *= -1;
    nlohmann::json rows = nlohmann::json::array();
    for (int r = 0; r < 4; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
    frames.push_back({{"file_path", name}, {"transform_matrix", rows}});
  }
  std::ofstream(dir / "transforms.json")
      << nlohmann::json{{"fl_x", 80}, {"w", 96}, {"h", 72}, {"frames", frames}};
}

TEST(Light, ExrSetsAreReadImportedAndRendered) {
  test::ScratchFolder scratch;
  WriteExrSet(scratch / "set");
  Import(scratch / "set", scratch / "imported", {.subject = Subject{Vector3d::Zero(), 0.3}});
  for (const char* name : {"set", "imported"}) {
    const LightField light_field = ReadLightField(scratch / name);
    const auto scene = LoadScene(light_field, {.subject = Subject{Vector3d::Zero(), 0.3}});
    const SceneView& view = scene->views[5];
    ASSERT_EQ(view.photograph->type(), CV_16FC4) << name;
    const cv::Mat truth = TenStops(view.camera, view.cam_from_world);
    cv::Mat loaded;
    view.photograph->Level(0).convertTo(loaded, CV_32F);
    EXPECT_NEAR(loaded.at<cv::Vec4f>(30, 90)[1], truth.at<cv::Vec3f>(30, 90)[1],
                1e-3 * truth.at<cv::Vec3f>(30, 90)[1]);
    // For eyes: white where there is more light than a display has.
    const cv::Mat shown = view.Srgb8();
    EXPECT_EQ(shown.at<cv::Vec3b>(30, 90)[1], 255);
  }
  EXPECT_EQ(cv::imread((scratch / "imported/images/5.png").string()).at<cv::Vec3b>(30, 90)[1], 255);
  const auto run =
      test::RunUlf("render " + (scratch / "imported").string() +
                   " --renderer reference --field linear --proxy plane -o " + (scratch / "out.exr").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("3 pixels of 1 photograph"));
  const cv::Mat rendered = ReadExr((scratch / "out.exr").string());
  EXPECT_GT(Brightest(rendered), 8);
  EXPECT_TRUE(cv::checkRange(rendered));
}

// Colours that an original claims are converted when it is read.
TEST(Light, AnUndistortedExrClaimsTheColoursThatItHas) {
  test::ScratchFolder scratch;
  WriteExrSet(scratch / "set");
  nlohmann::json set = JsonFromText(std::ifstream(scratch / "set/transforms.json"));
  set["k1"] = 0.05;
  std::ofstream(scratch / "set/transforms.json") << set;
  const cv::Mat light = ReadExr((scratch / "set/images/1.exr").string());
  std::array<float, 8> other = kRec709;
  other[0] = 0.7f;
  const std::array<ExrColors, 3> claims{kRec709, other, std::nullopt};
  for (std::size_t i = 0; i < claims.size(); ++i)
    WriteFileAtomically(
        scratch / fmt::format("set/images/{}.exr", i),
        ExrBytes({{"R", light, 2}, {"G", light, 1}, {"B", light, 0}}, ExrCompression::kZip, claims[i]));
  ExportLightField(ReadLightField(scratch / "set"), scratch / "out",
                   {.form = ExportForm::kNerfstudio, .undistort = true});
  for (std::size_t i = 0; i < claims.size(); ++i) {
    const std::string file = (scratch / fmt::format("out/images/{}.exr", i)).string();
    EXPECT_EQ(ExrColorsOf(file), claims[i] ? ExrColors(kRec709) : std::nullopt) << i;
  }
}

TEST(Light, MastersAreRenderedFromTheirSixteenBits) {
  test::ScratchFolder scratch;
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(96, 72, 80);
  {
    auto writer = LightFieldWriter::Create(scratch / "lf", header);
    for (const Vector3d& viewpoint : test::GridViewpoints(4, 3, 0.2, 2.0)) {
      View view;
      view.cam_from_world = LookAt(viewpoint, Vector3d::Zero(), Vector3d::UnitY());
      Frame frame;
      frame.image.transfer = Transfer::kLinear;
      // A dark scene: 8 bits of sRGB have two dozen values for it.
      test::LightOfPlane(header.camera, view.cam_from_world)
          .convertTo(frame.image.pixels, CV_16U, 0.01 * 65535);
      writer.AddView(frame, view);
    }
    writer.SetSubject({Vector3d::Zero(), 0.3});
    writer.Close(1);
  }
  const LightField light_field = ReadLightField(scratch / "lf");
  const auto scene = LoadScene(light_field, {});
  ASSERT_EQ(scene->views[5].photograph->type(), CV_16FC4);
  const SceneView& view = scene->views[5];
  const Rendering picture =
      MakeRenderer(scene, {.field = {.kind = FieldKind::kLinear}})->Render(view.camera, view.cam_from_world);
  const cv::Mat truth = 0.01 * test::LightOfPlane(view.camera, view.cam_from_world);
  EXPECT_LT(ShareBeyond(picture.linear, truth, 0.05f), 0.05);

  // 8 bits where they are asked for.
  EXPECT_EQ(LoadScene(light_field, {.form = PhotographForm::kEightBits})->views[5].photograph->type(),
            CV_8UC3);

  // Without its masters the light field is still one.
  std::filesystem::remove_all(scratch / "lf/masters");
  EXPECT_EQ(LoadScene(ReadLightField(scratch / "lf"), {})->views[5].photograph->type(), CV_8UC3);
}

// A hand before the lens, masked: without the mask it shows, with it the others fill in, and a left-out view
// does not count there. Both renderers; the same where alpha is the mask.
TEST(Light, MaskedPartsHaveNoWeight) {
  const cv::Rect hand(30, 20, 30, 30);
  enum class Masking { kNone, kFile, kAlpha };
  const auto write = [&](const std::filesystem::path& dir, Masking masking) {
    test::WriteLightField(dir, {.viewpoints = test::GridViewpoints(5, 5, 0.2, 2.0)}, true);
    LightField light_field = ReadLightField(dir);
    View& view = light_field.views[12];
    const std::string photograph = (dir / view.image_path).string();
    cv::Mat pixels = ReadImageFile(photograph);
    pixels(hand) = cv::Scalar(255, 0, 255);
    cv::Mat mask(pixels.size(), CV_8UC1, cv::Scalar(255));
    mask(hand) = 0;
    if (masking == Masking::kAlpha) {
      std::vector<cv::Mat> channels;
      cv::split(pixels, channels);
      channels.push_back(mask);
      cv::merge(channels, pixels);
    }
    cv::imwrite(photograph, pixels);
    if (masking != Masking::kFile) return;
    std::filesystem::create_directories(dir / "masks");
    view.mask_path = "masks/000013.png";
    cv::imwrite((dir / view.mask_path).string(), mask);
    WriteLightField(light_field);
  };
  test::ScratchFolder scratch;
  write(scratch / "none", Masking::kNone);
  write(scratch / "file", Masking::kFile);
  write(scratch / "alpha", Masking::kAlpha);
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const auto error = [&](const char* name) {
      const auto scene = LoadScene(ReadLightField(scratch / name), {});
      const SceneView& view = scene->views[12];
      const Rendering picture = MakeRenderer(scene, {.field = {.kind = FieldKind::kLinear}, .renderer = kind})
                                    ->Render(view.camera, view.cam_from_world);
      cv::Mat difference;
      cv::absdiff(picture.linear, test::LightOfPlane(view.camera, view.cam_from_world), difference);
      const cv::Scalar mean = cv::mean(difference(hand));
      return (mean[0] + mean[1] + mean[2]) / 3;
    };
    const double unmasked = error("none");
    EXPECT_GT(unmasked, 0.2) << "the hand must show without a mask";
    EXPECT_LT(error("file"), 0.1 * unmasked);
    EXPECT_LT(error("alpha"), 0.1 * unmasked);
  }
  const auto masked = LoadScene(ReadLightField(scratch / "file"), {});
  const cv::Mat valid = Undistort(masked->views[12]).valid;
  EXPECT_EQ(cv::countNonZero(valid(hand)), 0);
  EXPECT_EQ(cv::countNonZero(valid), static_cast<int>(valid.total()) - hand.area());
}

TEST(Light, FaultyExrFilesAreNamed) {
  test::ScratchFolder scratch;
  const cv::Mat light(8, 8, CV_32FC1, cv::Scalar::all(1));
  const std::string bytes = ExrBytes({{"Z", light}}, ExrCompression::kZip);
  std::ofstream(scratch / "layers.exr", std::ios::binary) << bytes;
  const std::string grey = ExrBytes({{"Y", light}}, ExrCompression::kZip);
  std::ofstream(scratch / "grey.exr", std::ios::binary) << grey;
  std::ofstream(scratch / "cut.exr", std::ios::binary) << grey.substr(0, grey.size() - 40);
  std::ofstream(scratch / "text.exr") << "not an image at all";
  EXPECT_EQ(ReadImageFile((scratch / "grey.exr").string()).at<cv::Vec3f>(3, 3), cv::Vec3f(1, 1, 1));
  for (const auto& [name, says] : {std::pair{"layers.exr", "neither R, G and B"},
                                   {"cut.exr", "truncated or damaged"},
                                   {"text.exr", "it is damaged, or of another kind"}}) {
    const std::string file = (scratch / name).string();
    EXPECT_THAT([&] { ReadImageFile(file); },
                testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr(name), HasSubstr(says))))
        << name;
  }
}

}  // namespace
}  // namespace ulf::light_test
