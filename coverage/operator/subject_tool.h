// Places the subject's sphere (thesis, section 3.2): the operator centres the subject, the tool takes the
// distance from the tracked points, and keys, wheel and drag refine distance and radius. The sphere is a
// draft until it is confirmed by Enter, which sends one request to the capture. The tool takes events and
// states and gives a draft and requests, without other effects.
#pragma once

#include <optional>

#include "coverage/operator/pending_requests.h"
#include "coverage/session/capture_state.h"
#include "render/display/surface.h"

namespace ulf::coverage {

class SubjectTool {
 public:
  bool is_open() const { return open_; }
  bool shows_aperture() const { return aperture_; }
  const std::optional<Subject>& draft() const { return draft_; }

  // Pauses recording while the tool is open; Close() resumes it unless the person has changed it since.
  void Open(const CaptureState& state, PendingRequests& pending);
  void Close(PendingRequests& pending);
  // Call it for every new state: a subject that the capture found on request becomes the draft, and the draft
  // follows corrections of the map.
  void Follow(const CaptureState& state, const PendingRequests& pending);
  // Returns true when the tool used the event. `pixels_per_img`: how many pixels of the screen show one of
  // the live picture, for dragging.
  bool Handle(const render::InputEvent& event, const CaptureState& state, double pixels_per_img,
              PendingRequests& pending);

 private:
  void TakeOver(PendingRequests& pending);
  void Leave(PendingRequests& pending);
  void FindAnew(PendingRequests& pending);
  bool Press(const render::KeyPressed& key, const CaptureState& state, PendingRequests& pending);
  void ScaleDistance(const CaptureState& state, double factor);
  void ScaleRadius(double factor);
  void MoveSideways(const CaptureState& state, const Eigen::Vector2d& by_img);

  bool open_ = false;
  bool aperture_ = true;
  std::optional<std::uint64_t> paused_;  // the request by which the tool paused recording
  std::optional<Subject> draft_;
  std::optional<Subject> of_capture_;
  std::optional<Subject> before_;  // when the tool was opened
  bool found_anew_ = false;        // since then, on request
  bool awaits_found_ = false;      // the capture has not answered yet
  std::optional<Eigen::Vector2d> mouse_;
  bool dragging_center_ = false, dragging_radius_ = false;
};

}  // namespace ulf::coverage
