#include "tracking/refine/refine_input.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <unordered_map>

#include "core/base/at.h"
#include "core/light_field/folder/view_images.h"
#include "tracking/map/pose_error.h"

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
  input.read_mask = [&light_field](int index) {
    const View& view = light_field.views[At(index)];
    return HasMask(light_field, view) ? ReadViewMask(light_field, view) : cv::Mat();
  };
  return input;
}

std::vector<ScenePoint> WithViewIds(std::vector<ScenePoint> points, const LightField& light_field) {
  for (ScenePoint& point : points)
    for (ViewObservation& seen : point.track) seen.view_id = light_field.views[At(seen.view_id)].id;
  return points;
}

std::vector<ScenePoint> WithoutMasked(std::vector<ScenePoint> points, const LightField& light_field) {
  std::unordered_map<int, std::vector<ViewObservation*>> seen_by;
  for (ScenePoint& point : points)
    for (ViewObservation& seen : point.track) seen_by[seen.view_id].push_back(&seen);
  constexpr int kNoView = 0;  // ids begin at 1
  for (const View& view : light_field.views) {
    const auto found = seen_by.find(view.id);
    if (found == seen_by.end() || !HasMask(light_field, view)) continue;
    const cv::Mat mask = ReadViewMask(light_field, view);
    if (mask.empty()) continue;
    for (ViewObservation* seen : found->second) {
      const cv::Point pixel(std::clamp(static_cast<int>(seen->in_img.x()), 0, mask.cols - 1),
                            std::clamp(static_cast<int>(seen->in_img.y()), 0, mask.rows - 1));
      if (mask.at<unsigned char>(pixel) == 0) seen->view_id = kNoView;
    }
  }
  std::erase_if(points, [](ScenePoint& point) {
    const auto masked =
        std::erase_if(point.track, [](const ViewObservation& seen) { return seen.view_id == kNoView; });
    return masked > 0 && point.track.size() < 2;
  });
  return points;
}

}  // namespace ulf::tracking
