#include "render/scene/scene.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/image/image.h"
#include "core/light_field/folder/view_images.h"
#include "render/scene/exposure_scales.h"

namespace ulf::render {
namespace {

// Returns whether other views show more light at each view's clipped pixels, because they were exposed less.
// It is false for views of one exposure: a place that clips in one of them and not in another looks different
// from there, and the highlight belongs to the picture.
std::vector<bool> ClipsLower(const std::vector<float>& scales, float least_ratio) {
  const float most = scales.empty() ? 1 : *std::ranges::max_element(scales);
  std::vector<bool> lower;
  for (const float scale : scales) lower.push_back(most > least_ratio * scale);
  return lower;
}

bool KnowsColors(const LightField& light_field) {
  return std::ranges::none_of(light_field.views, [&](const View& view) {
    return !HasRec709Colors(view) && !light_field.color_profiles.contains(view.camera);
  });
}

void ReportExposures(const LightField& light_field, const ExposureScales& scales) {
  if (!scales.estimated.empty())
    spdlog::info("{}: {} of unknown exposure matched by the points shared with others",
                 light_field.root.string(), Counted(scales.estimated.size(), "view"));
  if (!scales.unmatched.empty())
    spdlog::warn(
        "{}: nothing says how {} (the first is {}) had been exposed, and too few points are shared with "
        "others: shown as if of the median exposure; if too bright or too dark, measure points with ulf "
        "refine, or make a mesh with ulf proxy and give {} fit",
        light_field.root.string(), Counted(scales.unmatched.size(), "view"), scales.unmatched.front(),
        Parameter("light"));
}

// Decides kAuto: linear if 8 bits would lose light, because a master or a photograph holds more, a flat field
// is divided out, or exposures differ so much that photographs are brightened; and for masks, because only
// the linear form has pixels without light.
bool ReadsLinear(const LightField& light_field, const std::vector<float>& scales,
                 const SceneOptions& options) {
  if (options.form != PhotographForm::kAuto) return options.form == PhotographForm::kLinear;
  const auto [least, most] = std::ranges::minmax_element(scales);
  return *most > kMostExposureRatio * *least || !light_field.flat_fields.empty() ||
         !light_field.color_profiles.empty() || std::ranges::any_of(light_field.views, [&](const View& view) {
           return HasMoreThanEightBits(light_field, view) || HasMask(light_field, view);
         });
}

bool IsCutOut(const LightField& light_field) {
  return light_field.turntable &&
         std::ranges::all_of(light_field.views, [](const View& view) { return !view.mask_path.empty(); });
}

std::optional<Subject> KnownSubject(const LightField& light_field, const std::optional<Subject>& given) {
  if (given) return given;
  return light_field.subject ? light_field.subject : SubjectFromAxes(light_field);
}

// Views that look outwards from the midst of their points rarely show floor and ceiling, so they are gone
// round at their own height.
Subject AtTheHeightOfViews(Subject middle, const LightField& light_field) {
  std::size_t shown = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : light_field.views) {
    const CameraModel& camera = light_field.CameraOf(view);
    const auto img = camera.ImgFromCam(view.cam_from_world * middle.center_in_world);
    shown += img && camera.Contains(*img);
    mean += view.CenterInWorld() / static_cast<double>(light_field.views.size());
  }
  const Eigen::Vector3d to_views = mean - middle.center_in_world, up = light_field.UpInWorld();
  if (2 * shown < light_field.views.size() && to_views.norm() < middle.radius)
    middle.center_in_world += up.dot(to_views) * up;
  return middle;
}

// Poses of another convention render as empty pictures.
void WarnWhenAllLookAway(const LightField& light_field, const Subject& subject) {
  if (std::ranges::any_of(light_field.views, [&](const View& view) {
        return (view.cam_from_world * subject.center_in_world).z() > -subject.radius;
      }))
    return;
  spdlog::warn(
      "{}: every camera looks away from the subject: are the poses flipped (a camera looks along its z axis, "
      "y is down), or is the subject elsewhere ({} x,y,z,radius)?",
      light_field.root.string(), Parameter("subject"));
}

}  // namespace

float LightCorrection::Falloff(const CameraModel& camera, const Eigen::Vector2d& img) const {
  const Eigen::Vector2d half_diagonal(0.5 * camera.width, 0.5 * camera.height);
  const auto r2 = static_cast<float>((img - Eigen::Vector2d(camera.cx, camera.cy)).squaredNorm() /
                                     half_diagonal.squaredNorm());
  return 1 + r2 * (falloff_r2 + r2 * falloff_r4);
}

cv::Vec3f SceneView::ScaleAt(const Eigen::Vector2d& img) const {
  if (correction == LightCorrection{}) return cv::Vec3f::all(scale);
  const float at = scale / correction.Falloff(camera, img);
  return {at / correction.gain[0], at / correction.gain[1], at / correction.gain[2]};
}

cv::Mat SceneView::Srgb8() const {
  const cv::Mat pixels = photograph->Level(0);
  if (pixels.depth() == CV_8U) return pixels;
  cv::Mat linear, bgr;
  pixels.convertTo(linear, CV_32F);
  cv::cvtColor(linear, bgr, cv::COLOR_BGRA2BGR);
  return Srgb8FromLinear(bgr);
}

std::optional<Seen> SceneView::ProjectVisible(const Eigen::Vector3d& point_in_world) const {
  auto seen = Project(point_in_world);
  if (!seen || !shadow_map) return seen;
  seen->feather *= shadow_map->Get().Visibility(cam_from_world * point_in_world);
  if (seen->feather <= 0) return std::nullopt;
  return seen;
}

std::optional<Seen> SceneView::Project(const Eigen::Vector3d& point_in_world) const {
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

void RenderScene::MakeMesh() {
  mesh = MakeViewpointMesh(Centers(), subject, {mesh_in_plane, up_in_world});
  if (!has_subject && mesh.span == Span::kSurface) mesh.span = Span::kLine;
}

std::string RenderScene::ViewpointsInWords() const {
  if (has_subject || mesh.span == Span::kPlace) return mesh.Description();
  return fmt::format("{} without a subject: lumigraph weights; paths go round the middle of the points",
                     Counted(views.size(), "view"));
}

bool HasSubject(const LightField& light_field, const std::optional<Subject>& given) {
  return KnownSubject(light_field, given).has_value();
}

Subject SubjectOf(const LightField& light_field, const std::optional<Subject>& given) {
  if (const auto known = KnownSubject(light_field, given)) return *known;
  if (const auto middle = MiddleOfPoints(light_field)) return AtTheHeightOfViews(*middle, light_field);
  throw Refusal(
      light_field.root.string(), "",
      "the light field names no subject, its optical axes do not meet in front of the cameras (they are "
      "nearly parallel, there is one view, or the poses are flipped: a camera looks along its z axis, y is "
      "down), and it has too few points to stand for one",
      fmt::format("give its place with {} x,y,z,radius", Parameter("subject")));
}

std::shared_ptr<const RenderScene> LoadScene(const LightField& light_field, const SceneOptions& options) {
  if (light_field.views.empty())
    throw Error("{}: the light field holds no views; capture or import some first",
                light_field.root.string());
  auto scene = std::make_shared<RenderScene>();
  scene->has_subject = HasSubject(light_field, options.subject);
  scene->subject = SubjectOf(light_field, options.subject);
  scene->in_metres = light_field.units == "metres";
  scene->knows_exposures = KnowsExposures(light_field);
  scene->knows_colors = KnowsColors(light_field);
  scene->is_cut_out = IsCutOut(light_field);
  if (scene->has_subject) WarnWhenAllLookAway(light_field, scene->subject);
  scene->up_in_world = options.up_in_world.value_or(light_field.UpInWorld());
  const ExposureScales exposures = ScalesOf(light_field);
  ReportExposures(light_field, exposures);
  const std::vector<float>& scales = exposures.scales;
  scene->store = std::make_shared<PhotographStore>(
      light_field,
      PhotographStoreOptions{.linear = !options.of_masks && ReadsLinear(light_field, scales, options),
                             .masks = options.of_masks,
                             .size_limit_px = options.size_limit_px,
                             .memory_limit_mb = options.memory_limit_mb,
                             .masks_clipped = options.masks_clipped ? ClipsLower(scales, kMostExposureRatio)
                                                                    : std::vector<bool>()});
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    if (std::ranges::count(options.leave_out, static_cast<int>(i)) > 0) continue;
    const View& view = light_field.views[i];
    SceneView& out = scene->views.emplace_back();
    out.id = view.id;
    out.photograph = scene->store->PhotographOf(i);
    out.camera =
        light_field.CameraOf(view).ScaledTo(out.photograph->size().width, out.photograph->size().height);
    out.cam_from_world = view.cam_from_world;
    out.center_in_world = view.CenterInWorld();
    out.black = options.of_masks ? 0 : static_cast<float>(view.black_level);
    out.scale = options.of_masks ? 1 : scales[i];
  }
  scene->mesh_in_plane = options.mesh_in_plane;
  scene->MakeMesh();
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

std::shared_ptr<const RenderScene> WithProxy(const RenderScene& scene, std::shared_ptr<const Proxy> proxy) {
  auto other = std::make_shared<RenderScene>(scene);
  other->proxy = std::move(proxy);
  const auto occluder = other->proxy->Occluder();
  for (SceneView& view : other->views) {
    view.shadow_map = nullptr;
    if (occluder)
      view.shadow_map =
          std::make_shared<LazyShadowMap>([occluder, camera = view.camera, pose = view.cam_from_world] {
            return MakeShadowMap(*occluder, camera, pose);
          });
    view.depth_map = other->proxy->DepthMapOf(view.id, view.camera, view.cam_from_world);
  }
  return other;
}

std::shared_ptr<const RenderScene> Without(const RenderScene& scene, const std::vector<int>& left_out) {
  auto rest = std::make_shared<RenderScene>(scene);
  rest->views.clear();
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (std::ranges::count(left_out, static_cast<int>(i)) == 0) rest->views.push_back(scene.views[i]);
  rest->MakeMesh();
  return rest;
}

int PyramidLevel(const SceneView& view, const RenderScene& scene, const Eigen::Vector3d& virtual_center,
                 double output_focal_px) {
  const Eigen::Vector3d& center = scene.subject.center_in_world;
  const double view_distance = scene.has_subject ? (center - view.center_in_world).norm() : 1;
  const double output_distance = scene.has_subject ? (center - virtual_center).norm() : 1;
  if (!(view_distance > 0) || !(output_distance > 0)) return 0;
  const double texels_per_pixel =
      (view.camera.MeanFocalPx() / view_distance) / (output_focal_px / output_distance);
  const int level = static_cast<int>(std::lround(std::log2(texels_per_pixel)));
  return std::clamp(level, 0, view.photograph->LevelCount() - 1);
}

cv::Vec3f ViewColor(int view_id) {
  std::uint32_t h = static_cast<std::uint32_t>(view_id) * 2654435761u + 12345u;
  const auto next = [&h] {  // xorshift
    h ^= h << 13, h ^= h >> 17, h ^= h << 5;
    return static_cast<float>(h >> 8) / 16777216.0f;
  };
  next();
  // A random hue; saturation and brightness are high enough for neighbours to differ.
  const float hue = 6 * next(), saturation = 0.55f + 0.45f * next(), value = 0.55f + 0.45f * next();
  const auto channel = [&](float offset) {
    const float k = std::fmod(offset + hue, 6.0f);
    const float srgb = value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0f, 1.0f));
    return LinearFromSrgb(srgb);
  };
  return {channel(1), channel(3), channel(5)};
}

}  // namespace ulf::render
