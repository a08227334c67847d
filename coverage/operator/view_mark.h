// The recorded view nearest in direction to the review's camera, as seen from the subject: the one that the
// Delete key takes back.
#pragma once

#include <optional>

#include "coverage/operator/overlay.h"
#include "coverage/operator/pending_requests.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

struct MarkedView {
  int id = 0;
  render::Overlay shapes;  // in the camera's picture, where the view's direction meets the subject's sphere
};
// Of those that nobody has asked to take back. None without any.
std::optional<MarkedView> MarkNearestView(const CaptureState& state, const PendingRequests& pending,
                                          const CameraModel& camera, const Rigid3& cam_from_world,
                                          const Palette& palette);

}  // namespace ulf::coverage
