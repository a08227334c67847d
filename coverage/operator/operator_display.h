// What the person with the camera sees and presses (thesis, section 3.2): the live picture with the overlay,
// a status line, the subject tool with its augmented aperture, and the review. Draws the newest state of a
// capture and nothing else; whatever is asked of the capture is a CaptureRequest, so that a capture without a
// display can be asked the same.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coverage/operator/panels.h"
#include "coverage/operator/pending_requests.h"
#include "coverage/operator/posed_pictures.h"
#include "coverage/operator/recorded_pictures.h"
#include "coverage/operator/reprojection.h"
#include "coverage/operator/review.h"
#include "coverage/operator/subject_tool.h"
#include "coverage/session/capture_request.h"
#include "render/display/live_texture.h"
#include "render/display/painter.h"
#include "render/display/surface.h"

namespace ulf::coverage {

struct DisplayOptions {
  std::string marker;  // held before the camera to look round in review; empty: none
  bool colour_blind = false;
};

class OperatorDisplay {
 public:
  OperatorDisplay(render::Surface& surface, CaptureFeed& feed, CaptureRequests& requests,
                  const DisplayOptions& options = {});

  // Takes what has been pressed and draws the newest state. False once the window has been asked to close or
  // the capture to finish.
  bool Step(double patience_s = 0);
  // The light field is closed. True where the last words are worth a look: then any key ends Step().
  bool ShowTheEnd();
  // The capture goes on without a display: what only waited for the person no longer does. False: recording
  // stays paused, as the person had asked.
  bool LetGo();

 private:
  void Handle(render::InputEvent event);
  bool TakesBackMarked(const render::InputEvent& event);
  void HandleInAnyMode(const render::InputEvent& event);
  void Press(render::Key key);
  void Type(char32_t character);
  void Finish();
  void TakeStates();
  void Say(const std::string& words);
  void DrawFrame();
  void DrawLive(const CaptureState& state, const Panels& panels);
  void DrawSubjectTool(const CaptureState& state, const Panels& panels);
  void DrawReview(const CaptureState& state, const Panels& panels);
  const Palette& palette() const { return colour_blind_ ? Palette::ForColourBlind() : Palette::Standard(); }

  render::Surface& surface_;
  CaptureFeed& feed_;
  PendingRequests pending_;
  render::Painter painter_;
  render::LiveTexture live_;
  Reprojection reprojection_;
  SpreadPictures spread_;
  RecordedPictures recorded_;
  SubjectTool subject_tool_;
  Review review_;

  std::shared_ptr<const CaptureState> state_;
  bool state_is_new_ = false;
  render::Placement placement_;
  std::optional<int> marked_view_;  // on the screen, in review
  int marked_at_frame_ = 0;         // the first that showed it

  bool done_ = false;
  bool over_ = false;  // so is the capture
  bool colour_blind_ = false;
  bool keys_shown_ = false;
  bool legend_shown_ = true;
  bool close_look_shown_ = true;
  std::optional<bool> preflight_shown_;  // none: until the first view
  bool sound_ = false;
  bool was_held_ = true;
  int frames_ = 0;
  struct Said {
    std::string words;
    int at_frame = 0;
  };
  std::deque<Said> said_;  // still to be read
  std::uint64_t heard_of_capture_ = 0;
  bool preflight_seen_ = false;
  int preflight_until_frame_ = -1;
  int flash_until_frame_ = 0;
};

}  // namespace ulf::coverage
