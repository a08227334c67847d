#include "render/scene/renderer.h"

#include "core/base/error.h"
#include "render/gl/gl_renderer.h"
#include "render/scene/reference_renderer.h"

namespace ulf::render {

std::unique_ptr<Renderer> MakeRenderer(std::shared_ptr<const RenderScene> scene,
                                       const RenderOptions& options) {
  if (scene->views.empty()) throw Error("there are no views to render from; leave fewer of them out");
  if (options.renderer == RendererKind::kReference)
    return std::make_unique<ReferenceRenderer>(std::move(scene), options);
  return std::make_unique<GlRenderer>(std::move(scene), options);
}

void Renderer::Prefetch(const CameraModel& /*camera*/, const Rigid3& /*cam_from_world*/) {}

Filling FillingOf(const RenderOptions& options) {
  constexpr double kWholeWeight = 0.5;
  constexpr int kViews = 4;
  if (options.field.kind == FieldKind::kNearest) return {kLeastWeight, 1};
  if (!options.fill) return {};
  return {options.aperture ? kLeastWeight : kWholeWeight, kViews};
}

void RequireUndistorted(const CameraModel& camera) {
  camera.Validate("the virtual camera");
  if (camera.distortion != Distortion::kNone)
    throw Error("the virtual camera has lens distortion; render with CameraModel::WithoutDistortion()");
}

}  // namespace ulf::render
