#include "core/light_field/exchange/colmap_model.h"

#include <algorithm>
#include <unordered_map>

#include "core/light_field/exchange/image_names.h"

namespace ulf {
ColmapReconstruction::Camera ToColmapCamera(const CameraModel& camera) {
  ColmapReconstruction::Camera model;
  model.width = static_cast<std::uint64_t>(camera.width);
  model.height = static_cast<std::uint64_t>(camera.height);
  model.parameters = {camera.fx, camera.fy, camera.cx, camera.cy};
  const auto& c = camera.coefficients;
  const auto set = [&](int number, const char* name, std::initializer_list<double> more) {
    model.model = number;
    model.name = name;
    model.parameters.insert(model.parameters.end(), more);
  };
  const bool straight = camera.distortion == Distortion::kRadialTangential && c == std::array<double, 5>{};
  if (camera.distortion == Distortion::kNone || straight)
    set(1, "PINHOLE", {});
  else if (camera.distortion == Distortion::kFisheye)
    set(5, "OPENCV_FISHEYE", {c[0], c[1], c[2], c[3]});
  else if (c[4] == 0)
    set(4, "OPENCV", {c[0], c[1], c[2], c[3]});
  else
    set(6, "FULL_OPENCV", {c[0], c[1], c[2], c[3], c[4], 0, 0, 0});
  return model;
}

ColmapReconstruction ToColmap(const LightField& light_field) {
  ColmapReconstruction model;
  for (const CameraModel& camera : light_field.cameras) {
    model.cameras.push_back(ToColmapCamera(camera));
    model.cameras.back().id = static_cast<std::uint32_t>(model.cameras.size());
  }
  std::unordered_map<int, std::size_t> image_of_view;
  for (const View& view : light_field.views) {
    image_of_view[view.id] = model.images.size();
    model.images.push_back({static_cast<std::uint32_t>(view.id),
                            static_cast<std::uint32_t>(view.camera) + 1,
                            view.cam_from_world,
                            SafeName(NameInImagesFolder(view.image_path)),
                            {}});
  }
  const bool some_are_tracked = std::any_of(light_field.points.begin(), light_field.points.end(),
                                            [](const ScenePoint& point) { return !point.track.empty(); });
  for (const ScenePoint& from : light_field.points) {
    if (some_are_tracked && from.track.empty()) continue;
    ColmapReconstruction::Point& point = model.points.emplace_back();
    point.id = model.points.size();
    point.position = from.position_in_world;
    point.rgb = from.rgb;
    point.error_px = from.error_px;
    for (const ViewObservation& seen : from.track) {
      const auto at = image_of_view.find(seen.view_id);
      if (at == image_of_view.end()) continue;
      ColmapReconstruction::Image& image = model.images[at->second];
      point.track.push_back({image.id, static_cast<std::uint32_t>(image.points.size())});
      image.points.push_back({seen.in_img, point.id});
    }
  }
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const CameraModel& camera = light_field.CameraOf(light_field.views[i]);
    if (model.images[i].points.empty()) model.images[i].points.push_back({{camera.cx, camera.cy}});
  }
  return model;
}

}  // namespace ulf
