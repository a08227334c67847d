// Placing the subject's sphere (thesis, section 3.2): centre the subject, take the distance from the tracked
// points, then refine distance and radius by keys, wheel and drag. A draft until it is taken over: the
// capture learns of it by one request. Pure: events and states in, a draft and requests out.
#pragma once

#include <optional>

#include "coverage/capture_request.h"
#include "coverage/capture_state.h"
#include "coverage/operator/surface.h"

namespace ulf {

class SubjectTool {
 public:
  bool is_open() const { return open_; }
  bool shows_aperture() const { return aperture_; }
  const std::optional<Subject>& draft() const { return draft_; }

  // Recording pauses while the tool is open, where it was on.
  void Open(const CaptureState& state, CaptureRequests& requests);
  // Every new state: a subject that the capture found anew is the new draft.
  void Follow(const CaptureState& state);
  // True when the event was the tool's. `pixels_per_img`: of the screen, for dragging.
  bool Handle(const InputEvent& event, const CaptureState& state, double pixels_per_img,
              CaptureRequests& requests);

 private:
  void Close(CaptureRequests& requests);
  void ScaleDistance(const CaptureState& state, double factor);
  void ScaleRadius(double factor);
  void MoveSideways(const CaptureState& state, const Eigen::Vector2d& by_img);

  bool open_ = false;
  bool aperture_ = true;
  bool resume_ = false;  // recording, when the tool closes
  std::optional<Subject> draft_;
  std::optional<Subject> of_capture_;
  std::optional<Eigen::Vector2d> mouse_;
  bool dragging_center_ = false, dragging_radius_ = false;
};

}  // namespace ulf
