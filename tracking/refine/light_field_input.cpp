#include "tracking/refine/light_field_input.h"

#include "core/base/at.h"
#include "core/light_field/light_field_io.h"
#include "tracking/estimation/pose_error.h"

namespace ulf::tracking {

RefineInput RefineInputOf(const LightField& light_field) {
  RefineInput input;
  input.lenses = light_field.cameras;
  for (const View& view : light_field.views)
    input.views.push_back(
        {view.image_path, view.camera, view.cam_from_world, ErrorShareOf(view.tracking_quality),
         view.twist ? std::optional<Twist>(Eigen::Map<const Twist>(view.twist->data())) : std::nullopt});
  if (light_field.readout) input.readout_s = light_field.readout->readout_s;
  input.read = [&light_field](int index) {
    return ReadRecordedImage(light_field, light_field.views[At(index)]);
  };
  return input;
}

std::vector<ScenePoint> WithViewIds(std::vector<ScenePoint> points, const LightField& light_field) {
  for (ScenePoint& point : points)
    for (ViewObservation& seen : point.track) seen.view_id = light_field.views[At(seen.view_id)].id;
  return points;
}

}  // namespace ulf::tracking
