#include "render/scene.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "acquisition/error.h"
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

double TotalMegabytes(const LightField& light_field, int size_limit_px, int halvings) {
  double bytes = 0;
  for (const View& view : light_field.views) {
    const CameraModel& camera = light_field.CameraOf(view);
    const double longer = std::max(camera.width, camera.height);
    double scale = size_limit_px > 0 ? std::min(1.0, size_limit_px / longer) : 1.0;
    scale = std::ldexp(scale, -halvings);
    bytes +=
        4.0 * camera.width * camera.height * scale * scale;  // three channels and a third for the pyramid
  }
  return bytes / 1e6;
}

cv::Size LoadedSize(const CameraModel& camera, int size_limit_px, int halvings) {
  const double longer = std::max(camera.width, camera.height);
  double scale = size_limit_px > 0 ? std::min(1.0, size_limit_px / longer) : 1.0;
  scale = std::ldexp(scale, -halvings);
  return {std::max(1, static_cast<int>(std::lround(camera.width * scale))),
          std::max(1, static_cast<int>(std::lround(camera.height * scale)))};
}

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

std::optional<Seen> SceneView::See(const Eigen::Vector3d& point_in_world) const {
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
  while (TotalMegabytes(light_field, options.size_limit_px, scene->halvings) > options.memory_limit_mb)
    ++scene->halvings;
  if (scene->halvings > 0)
    spdlog::warn("photographs are loaded at 1/{} of their size to fit into {:.0f} MB", 1 << scene->halvings,
                 options.memory_limit_mb);

  const std::vector<float> scales = ExposureScales(light_field);
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    if (std::count(options.leave_out.begin(), options.leave_out.end(), static_cast<int>(i)) > 0) continue;
    const View& view = light_field.views[i];
    const CameraModel& camera = light_field.CameraOf(view);
    cv::Mat pixels = Srgb8(ReadViewImage(light_field, view));
    const cv::Size size = LoadedSize(camera, options.size_limit_px, scene->halvings);
    if (size != pixels.size()) {
      cv::Mat smaller;
      cv::resize(LinearFloat({.pixels = pixels, .transfer = Transfer::kSrgb}), smaller, size, 0, 0,
                 cv::INTER_AREA);
      pixels = Srgb8FromLinear(smaller);
    }
    SceneView& out = scene->views.emplace_back();
    out.id = view.id;
    out.camera = camera.ScaledTo(size.width, size.height);
    out.cam_from_world = view.cam_from_world;
    out.center_in_world = view.CenterInWorld();
    out.pyramid = MakePyramid(pixels);
    out.black = static_cast<float>(view.black_level);
    out.scale = scales[i];
    if (progress)
      progress->Show(static_cast<double>(i + 1) / static_cast<double>(light_field.views.size()),
                     view.image_path);
  }
  scene->mesh = MakeViewpointMesh(scene->Centers(), scene->subject);
  return scene;
}

std::shared_ptr<const RenderScene> Without(const RenderScene& scene, const std::vector<int>& left_out) {
  auto rest = std::make_shared<RenderScene>();
  rest->subject = scene.subject;
  rest->up_in_world = scene.up_in_world;
  rest->halvings = scene.halvings;
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (std::count(left_out.begin(), left_out.end(), static_cast<int>(i)) == 0)
      rest->views.push_back(scene.views[i]);
  rest->mesh = MakeViewpointMesh(rest->Centers(), rest->subject);
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
