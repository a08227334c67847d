#include "render/renderer/renderer.h"

#include "core/base/error.h"
#include "render/fields/field_options.h"

namespace ulf::render {

void Renderer::Prefetch(const CameraModel& /*camera*/, const Rigid3& /*cam_from_world*/) {}

Filling FillingOf(const RenderOptions& options, const FillingOptions& filling) {
  if (options.field.kind == FieldKind::kNearest) return {kLeastWeight, 1};
  if (!options.fill) return {};
  return {options.aperture ? kLeastWeight : filling.whole_weight, filling.views};
}

void RequireUndistorted(const CameraModel& camera) {
  camera.Validate("the virtual camera");
  if (camera.distortion != Distortion::kNone)
    throw Error("the virtual camera has lens distortion; render with CameraModel::WithoutDistortion()");
}

}  // namespace ulf::render
