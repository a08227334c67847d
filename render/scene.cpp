#include "render/scene.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/counted.h"
#include "acquisition/error.h"
#include "acquisition/exr_file.h"
#include "acquisition/image.h"
#include "acquisition/light_field_io.h"

namespace ulf {
namespace {

// Exposure times gain (over f-number squared), the median view's being 1; all 1 where some view does not say.
std::vector<float> ExposureScales(const LightField& light_field) {
  std::vector<double> exposures;
  for (const View& view : light_field.views) {
    const double aperture = view.f_number ? 1 / (*view.f_number * *view.f_number) : 1.0;
    exposures.push_back(view.exposure_s * view.gain * aperture);
  }
  std::vector<float> scales(exposures.size(), 1.0f);
  if (exposures.empty() || *std::min_element(exposures.begin(), exposures.end()) <= 0) return scales;
  std::vector<double> sorted = exposures;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  for (std::size_t i = 0; i < scales.size(); ++i) scales[i] = static_cast<float>(median / exposures[i]);
  return scales;
}

// Where 8 bits would lose light: a master or a photograph holds more, a flat field is divided out, or
// exposures are more than a stop apart, so that some photographs are lifted out of their shadows.
bool NeedsLinear(const LightField& light_field, const std::vector<float>& scales) {
  const auto [least, most] = std::minmax_element(scales.begin(), scales.end());
  return *most > 2 * *least || !light_field.flat_fields.empty() ||
         std::any_of(light_field.views.begin(), light_field.views.end(),
                     [&](const View& view) { return HasMoreThanEightBits(light_field, view); });
}

double TotalMegabytes(const LightField& light_field, int size_limit_px, int halvings, bool linear) {
  // Three channels of a byte, or four halves; and a third for the pyramid.
  const double bytes_a_pixel = (linear ? 8.0 : 3.0) * 4 / 3;
  double bytes = 0;
  for (const View& view : light_field.views) {
    const CameraModel& camera = light_field.CameraOf(view);
    const double longer = std::max(camera.width, camera.height);
    double scale = size_limit_px > 0 ? std::min(1.0, size_limit_px / longer) : 1.0;
    scale = std::ldexp(scale, -halvings);
    bytes += bytes_a_pixel * camera.width * camera.height * scale * scale;
  }
  return bytes / 1e6;
}

int HalvingsThatFit(const LightField& light_field, const SceneOptions& options, bool linear) {
  int halvings = 0;
  while (TotalMegabytes(light_field, options.size_limit_px, halvings, linear) > options.memory_limit_mb)
    ++halvings;
  return halvings;
}

bool LoadsLinear(const LightField& light_field, const std::vector<float>& scales,
                 const SceneOptions& options) {
  if (options.form != PhotographForm::kAuto) return options.form == PhotographForm::kLinear;
  if (!NeedsLinear(light_field, scales)) return false;
  if (HalvingsThatFit(light_field, options, true) == HalvingsThatFit(light_field, options, false))
    return true;
  spdlog::info(
      "8 bits of the photographs are loaded: what they hold beyond would cost resolution (--memory-mb {:.0f} "
      "has room for both)",
      std::ceil(TotalMegabytes(light_field, options.size_limit_px, 0, true)));
  return false;
}

cv::Size LoadedSize(const CameraModel& camera, int size_limit_px, int halvings) {
  const double longer = std::max(camera.width, camera.height);
  double scale = size_limit_px > 0 ? std::min(1.0, size_limit_px / longer) : 1.0;
  scale = std::ldexp(scale, -halvings);
  return {std::max(1, static_cast<int>(std::lround(camera.width * scale))),
          std::max(1, static_cast<int>(std::lround(camera.height * scale)))};
}

cv::Mat ResizedInLight(const cv::Mat& srgb8, const cv::Size& size) {
  if (size == srgb8.size()) return srgb8;
  cv::Mat smaller;
  cv::resize(LinearFloat({.pixels = srgb8, .transfer = Transfer::kSrgb}), smaller, size, 0, 0,
             cv::INTER_AREA);
  return Srgb8FromLinear(smaller);
}

// Pixels that are not finite.
struct GapCount {
  std::size_t pixels = 0, photographs = 0;
  bool Add(const cv::Mat& light) {
    const std::size_t before = pixels;
    for (int y = 0; y < light.rows; ++y)
      for (int x = 0; x < light.cols; ++x) {
        const cv::Vec3f& pixel = light.at<cv::Vec3f>(y, x);
        pixels += !(std::isfinite(pixel[0]) && std::isfinite(pixel[1]) && std::isfinite(pixel[2]));
      }
    photographs += pixels > before;
    return pixels > before;
  }
};

}  // namespace

ViewPyramid MakePyramid(const cv::Mat& srgb8) {
  ViewPyramid levels{srgb8};
  cv::Mat linear = LinearFloat({.pixels = srgb8, .transfer = Transfer::kSrgb});
  while (linear.cols > 1 || linear.rows > 1) {
    cv::Mat half;
    cv::resize(linear, half, {std::max(1, linear.cols / 2), std::max(1, linear.rows / 2)}, 0, 0,
               cv::INTER_AREA);
    levels.push_back(Srgb8FromLinear(half));
    linear = half;
  }
  return levels;
}

ViewPyramid MakeLinearPyramid(const cv::Mat& linear, cv::Size size) {
  cv::Mat level(linear.size(), CV_32FC4);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const cv::Vec3f& light = linear.at<cv::Vec3f>(y, x);
      const bool finite = std::isfinite(light[0]) && std::isfinite(light[1]) && std::isfinite(light[2]);
      level.at<cv::Vec4f>(y, x) = finite ? cv::Vec4f(light[0], light[1], light[2], 1) : cv::Vec4f(0, 0, 0, 0);
    }
  if (!size.empty() && size != level.size()) cv::resize(level.clone(), level, size, 0, 0, cv::INTER_AREA);
  ViewPyramid levels{HalfFromFloat(level)};
  while (level.cols > 1 || level.rows > 1) {
    cv::Mat half;
    cv::resize(level, half, {std::max(1, level.cols / 2), std::max(1, level.rows / 2)}, 0, 0, cv::INTER_AREA);
    levels.push_back(HalfFromFloat(half));
    level = half;
  }
  return levels;
}

cv::Mat SceneView::Srgb8() const {
  const cv::Mat& photograph = pyramid.front();
  if (photograph.depth() == CV_8U) return photograph;
  cv::Mat linear, bgr;
  photograph.convertTo(linear, CV_32F);
  cv::cvtColor(linear, bgr, cv::COLOR_BGRA2BGR);
  return Srgb8FromLinear(bgr);
}

std::optional<Seen> SceneView::See(const Eigen::Vector3d& point_in_world) const {
  auto seen = Frame(point_in_world);
  if (!seen || !sight) return seen;
  seen->feather *= sight->Share(cam_from_world * point_in_world);
  if (seen->feather <= 0) return std::nullopt;
  return seen;
}

std::optional<Seen> SceneView::Frame(const Eigen::Vector3d& point_in_world) const {
  const auto img = camera.ImgFromCam(cam_from_world * point_in_world);
  if (!img) return std::nullopt;
  const double to_edge = std::min({img->x(), img->y(), camera.width - img->x(), camera.height - img->y()});
  if (!(to_edge > 0)) return std::nullopt;
  return Seen{*img, std::min(1.0, to_edge / (kFeatherShare * std::min(camera.width, camera.height)))};
}

std::vector<Eigen::Vector3d> RenderScene::Centers() const {
  std::vector<Eigen::Vector3d> centers;
  for (const SceneView& view : views) centers.push_back(view.center_in_world);
  return centers;
}

void RenderScene::MakeMesh() { mesh = MakeViewpointMesh(Centers(), subject, {mesh_in_plane, up_in_world}); }

Subject SubjectOf(const LightField& light_field, const std::optional<Subject>& given) {
  if (given) return *given;
  if (light_field.subject) return *light_field.subject;
  if (const auto found = SubjectFromAxes(light_field)) return *found;
  throw UsageError(
      "{}: the light field names no subject and its optical axes meet nowhere (they are nearly parallel, or "
      "there is "
      "one view); say where it is with --subject x,y,z,radius",
      light_field.root.string());
}

std::shared_ptr<const RenderScene> LoadScene(const LightField& light_field, const SceneOptions& options,
                                             Progress* progress) {
  if (light_field.views.empty())
    throw Error("{}: the light field holds no views; capture or import some first",
                light_field.root.string());
  auto scene = std::make_shared<RenderScene>();
  scene->subject = SubjectOf(light_field, options.subject);
  scene->up_in_world = light_field.UpInWorld();
  const std::vector<float> scales = ExposureScales(light_field);
  const bool linear = LoadsLinear(light_field, scales, options);
  scene->halvings = HalvingsThatFit(light_field, options, linear);
  if (scene->halvings > 0)
    spdlog::warn("photographs are loaded at 1/{} of their size to fit into {:.0f} MB", 1 << scene->halvings,
                 options.memory_limit_mb);

  GapCount gaps;
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    if (std::count(options.leave_out.begin(), options.leave_out.end(), static_cast<int>(i)) > 0) continue;
    const View& view = light_field.views[i];
    const CameraModel& camera = light_field.CameraOf(view);
    const cv::Size size = LoadedSize(camera, options.size_limit_px, scene->halvings);
    SceneView& out = scene->views.emplace_back();
    out.id = view.id;
    out.camera = camera.ScaledTo(size.width, size.height);
    out.cam_from_world = view.cam_from_world;
    out.center_in_world = view.CenterInWorld();
    if (linear) {
      const cv::Mat light = LinearFloat(ReadViewLight(light_field, view));
      out.has_gaps = gaps.Add(light);
      out.pyramid = MakeLinearPyramid(light, size);
    } else {
      out.pyramid = MakePyramid(ResizedInLight(Srgb8(ReadViewImage(light_field, view)), size));
    }
    out.black = static_cast<float>(view.black_level);
    out.scale = scales[i];
    if (progress)
      progress->Show(static_cast<double>(i + 1) / static_cast<double>(light_field.views.size()),
                     view.image_path);
  }
  if (gaps.pixels > 0)
    spdlog::warn("{} of {} are infinite or not numbers: they have no weight", Counted(gaps.pixels, "pixel"),
                 Counted(gaps.photographs, "photograph"));
  scene->mesh_in_plane = options.mesh_in_plane;
  scene->MakeMesh();
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

std::shared_ptr<const RenderScene> WithProxy(const RenderScene& scene, std::shared_ptr<const Proxy> proxy) {
  auto other = std::make_shared<RenderScene>(scene);
  other->proxy = std::move(proxy);
  const auto occluder = other->proxy->Occluder();
  cv::parallel_for_({0, static_cast<int>(other->views.size())}, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      SceneView& view = other->views[static_cast<std::size_t>(i)];
      view.sight = occluder ? std::make_shared<Sight>(MakeSight(*occluder, view.camera, view.cam_from_world))
                            : nullptr;
    }
  });
  return other;
}

std::shared_ptr<const RenderScene> Without(const RenderScene& scene, const std::vector<int>& left_out) {
  auto rest = std::make_shared<RenderScene>();
  rest->subject = scene.subject;
  rest->up_in_world = scene.up_in_world;
  rest->halvings = scene.halvings;
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (std::count(left_out.begin(), left_out.end(), static_cast<int>(i)) == 0)
      rest->views.push_back(scene.views[i]);
  rest->proxy = scene.proxy;
  rest->mesh_in_plane = scene.mesh_in_plane;
  rest->MakeMesh();
  return rest;
}

int PyramidLevel(const SceneView& view, const Subject& subject, const Eigen::Vector3d& virtual_center,
                 double output_focal_px) {
  const double view_distance = (subject.center_in_world - view.center_in_world).norm();
  const double output_distance = (subject.center_in_world - virtual_center).norm();
  if (!(view_distance > 0) || !(output_distance > 0)) return 0;
  const double texels_per_pixel =
      (view.camera.MeanFocalPx() / view_distance) / (output_focal_px / output_distance);
  const int level = static_cast<int>(std::lround(std::log2(texels_per_pixel)));
  return std::clamp(level, 0, static_cast<int>(view.pyramid.size()) - 1);
}

cv::Vec3f ViewColor(int index) {
  std::uint32_t h = static_cast<std::uint32_t>(index) * 2654435761u + 12345u;
  const auto next = [&h] {  // xorshift
    h ^= h << 13, h ^= h >> 17, h ^= h << 5;
    return static_cast<float>(h >> 8) / 16777216.0f;
  };
  next();
  // Hue at random; saturation and brightness high enough that neighbours differ.
  const float hue = 6 * next(), saturation = 0.55f + 0.45f * next(), value = 0.55f + 0.45f * next();
  const auto channel = [&](float offset) {
    const float k = std::fmod(offset + hue, 6.0f);
    const float srgb = value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0f, 1.0f));
    return LinearFromSrgb(srgb);
  };
  return {channel(1), channel(3), channel(5)};
}

}  // namespace ulf
