#include "python/opened_field.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <set>

#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/proxy_choice.h"
#include "render/proxy/view_depth_map.h"
#include "render/quality/evaluate.h"
#include "render/quality/quality.h"
#include "render/renderer/cut_out_renderer.h"

namespace ulf::python {

cv::Mat OpenedField::Render(const CameraModel& camera, const Rigid3& cam_from_world) {
  const MutexLock lock(mutex_);
  if (!renderer_) renderer_ = MakeOwnRenderer();
  return renderer_->Render(camera, cam_from_world).linear;
}

std::vector<LeftOutPicture> OpenedField::LeftOut(const std::vector<int>& ids, const std::string& proxy) {
  const MutexLock lock(mutex_);
  const std::shared_ptr<const render::RenderScene> scene = Scene();
  render::EvaluateOptions options{.fields = {render::DefaultField(*scene)}, .renderer = Kind()};
  std::set<int> left_out;  // indices
  for (const int id : ids) {
    const auto view = std::ranges::find(scene->views, id, &render::SceneView::id);
    if (view == scene->views.end())
      throw Refusal("ids", std::to_string(id), "is no view of this light field", "");
    left_out.insert(static_cast<int>(view - scene->views.begin()));
  }
  options.left_out.assign(left_out.begin(), left_out.end());
  if (options.left_out.empty() || options.left_out.size() == scene->views.size())
    throw Refusal("ids", "", "some views have to be left out and some have to stay", "");
  options.proxies = {proxy == "auto" ? Geometry()
                                     : render::ProxyFromName(proxy, scene->subject, light_field_.root)};
  std::vector<LeftOutPicture> pictures;
  options.look = [&](const render::ComparedPicture& seen) {
    pictures.push_back({seen.view_id, seen.rendered.clone(), seen.photograph.clone(), seen.valid.clone()});
    const render::Quality quality = render::CompareImages(seen.rendered, seen.photograph, seen.valid);
    pictures.back().psnr_db = quality.psnr_db;
    pictures.back().ssim = quality.ssim;
  };
  render::Evaluate(*scene, options);
  return pictures;
}

SeenDepth OpenedField::DepthOf(const View& view) {
  const MutexLock lock(mutex_);
  const std::shared_ptr<const render::Proxy> proxy = Geometry();
  if (!proxy->Occluder())
    throw Error("{}: has no mesh and no depth maps; make them with: ulf proxy {}", light_field_.root.string(),
                ShellWord(light_field_.root.string()));
  const CameraModel camera = light_field_.CameraOf(view).WithoutDistortion();
  const auto lazy = proxy->DepthMapOf(view.id, camera, view.cam_from_world);
  if (!lazy) return {proxy->Depth(camera, view.cam_from_world), camera};
  const render::ViewDepthMap& map = lazy->Get();
  cv::Mat depth(map.inverse_depth.size(), CV_32F);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const double inverse = map.InverseDepthAt(x, y);
      depth.at<float>(y, x) =
          inverse > 0 ? static_cast<float>(1 / inverse) : std::numeric_limits<float>::quiet_NaN();
    }
  return {depth, map.camera};
}

std::shared_ptr<const render::RenderScene> OpenedField::Scene() {
  if (!scene_) scene_ = render::LoadScene(light_field_, {});
  return scene_;
}

std::shared_ptr<const render::Proxy> OpenedField::Geometry() {
  if (!proxy_)
    proxy_ = render::OwnProxy(render::DefaultProxies(light_field_.root).front(),
                              render::SubjectOf(light_field_), light_field_.root);
  return proxy_;
}

// OpenGL, or without it the same pictures from the processor, slowly.
render::RendererKind OpenedField::Kind() {
  if (kind_) return *kind_;
  kind_ = render::RendererKind::kGl;
  try {
    const render::GlContext tried;
  } catch (const Error& error) {
    spdlog::warn("{}; the reference renderer draws the pictures, slowly", error.what());
    kind_ = render::RendererKind::kReference;
  }
  return *kind_;
}

std::unique_ptr<render::Renderer> OpenedField::MakeOwnRenderer() {
  const auto scene = Scene();
  const render::RenderOptions options{.field = render::DefaultField(*scene), .renderer = Kind()};
  auto of_light = render::MakeRenderer(render::WithProxy(*scene, Geometry()), options);
  if (!scene->is_cut_out) return of_light;
  const auto masks = render::LoadScene(light_field_, {.of_masks = true});
  return std::make_unique<render::CutOutRenderer>(
      std::move(of_light), render::MakeRenderer(render::WithProxy(*masks, Geometry()), options));
}

CapCoverage CoverageOfCap(const LightField& light_field,
                          const std::optional<std::pair<double, double>>& cap_deg,
                          const std::optional<double>& threshold_px) {
  if (!render::HasSubject(light_field))
    throw Refusal(light_field.root.string(), "", "names no subject, around which a cap could lie",
                  "a capture or an import with a subject has one");
  std::optional<coverage::Cap> cap;
  if (cap_deg)
    cap = coverage::Cap::ParseDegrees(std::to_string(cap_deg->first) + "x" + std::to_string(cap_deg->second));
  else if (light_field.goal)
    cap = coverage::Cap::FromDegrees(light_field.goal->cap_deg);
  if (threshold_px && !(*threshold_px > 0))
    throw Refusal("threshold_px", std::to_string(*threshold_px), "is no number of pixels", "give 7 or so");
  CapCoverage coverage{
      coverage::CoverageOf(
          light_field, render::SubjectOf(light_field), cap,
          threshold_px.value_or(light_field.threshold_px.value_or(coverage::kHighThresholdPx))),
      {},
      {}};
  coverage.map.ForEachCell([&](const auto& cell) { coverage.cells.push_back(cell); });
  for (const View& view : light_field.views) coverage.view_ids.push_back(view.id);
  return coverage;
}

}  // namespace ulf::python
