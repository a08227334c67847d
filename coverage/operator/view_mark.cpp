#include "coverage/operator/view_mark.h"

#include <fmt/core.h>

namespace ulf::coverage {

using Eigen::Vector3d;

std::optional<MarkedView> MarkNearestView(const CaptureState& state, const PendingRequests& pending,
                                          const CameraModel& camera, const Rigid3& cam_from_world,
                                          const Palette& palette) {
  if (!state.subject || !state.coverage) return std::nullopt;
  const Vector3d& center = state.subject->center_in_world;
  const Vector3d offset = cam_from_world.OriginInSource() - center;
  std::optional<std::size_t> nearest;
  Vector3d nearest_direction = Vector3d::Zero();
  for (std::size_t i = 0; i < state.view_ids.size(); ++i) {
    const Vector3d direction = (state.coverage->views()[i].center_in_world - center).normalized();
    if (pending.IsTakenBack(state.view_ids[i])) continue;
    if (nearest && direction.dot(offset) <= nearest_direction.dot(offset)) continue;
    nearest = i;
    nearest_direction = direction;
  }
  if (!nearest) return std::nullopt;
  MarkedView marked{.id = state.view_ids[*nearest], .shapes = {}};
  // The sphere's far side is not seen.
  if (nearest_direction.dot(offset) < state.subject->radius) return marked;
  const auto img =
      camera.ImgFromCam(cam_from_world * Vector3d(center + state.subject->radius * nearest_direction));
  if (!img || !camera.Contains(*img)) return marked;
  marked.shapes = {render::Spot{*img, 8, {0, 0, 0, 120}}, render::Spot{*img, 7, {255, 255, 255}},
                   render::Spot{*img, 5, palette.guide},
                   render::Label{.img = *img + Eigen::Vector2d(0, -0.02 * camera.height),
                                 .text = fmt::format("view {}", marked.id),
                                 .size = 17,
                                 .color = {255, 255, 255},
                                 .anchor = {0.5, 1}}};
  return marked;
}

}  // namespace ulf::coverage
