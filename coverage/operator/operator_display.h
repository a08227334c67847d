// Shows the operator display (thesis, section 3.2): the live picture with the overlay, a status line, the
// subject tool with its augmented aperture, and the review. The display draws the newest CaptureState alone,
// and controls the capture by CaptureRequests, which also work without a display. It belongs to one thread,
// that of its surface's OpenGL context (run_with_display.h).
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coverage/operator/overlay.h"
#include "coverage/operator/panels.h"
#include "coverage/operator/pending_requests.h"
#include "coverage/operator/posed_pictures.h"
#include "coverage/operator/recorded_pictures.h"
#include "coverage/operator/rendered_review.h"
#include "coverage/operator/reprojection.h"
#include "coverage/operator/review.h"
#include "coverage/operator/subject_tool.h"
#include "coverage/session/capture_request.h"
#include "render/display/live_texture.h"
#include "render/display/painter.h"
#include "render/display/surface.h"

namespace ulf::coverage {

struct DisplayOptions {
  std::string marker;  // held before the camera to look round in review (Review); empty: none
  // Returns the present time in seconds of any origin, once for each picture; none: this machine's clock.
  std::function<double()> clock_s = nullptr;
};

class OperatorDisplay {
 public:
  // `surface`, `feed` and `requests` outlive it. Throws Refusal for a marker that is none.
  OperatorDisplay(render::Surface& surface, CaptureFeed& feed, CaptureRequests& requests,
                  const DisplayOptions& options = {});

  // Handles the input, for which it waits `patience_s` at most, and draws the newest state. Returns false
  // once the window was closed or the capture was asked to finish.
  bool Step(double patience_s = 0);
  // Call it when the light field is closed. Returns true when the final state should stay on the screen,
  // because the cap is covered; Step() then returns false after any key.
  bool ShowFinalState();
  // Lets the capture go on without the display: closes the subject tool, so that recording resumes where only
  // the tool had paused it, and begins to record where the operator has not, also before the first state.
  // Returns false when recording stays paused by request.
  bool Detach();

 private:
  void Handle(render::InputEvent event);
  bool HandleTakeBack(const render::InputEvent& event);
  bool HandleStripes(const render::InputEvent& event);
  void Press(const render::KeyPressed& pressed);
  void Type(char32_t character);
  void TakeBackLast();
  void TakeProposedSubject();
  void ShowOtherLayer();
  void Finish();
  void TakeStates();
  void Say(const std::string& words);
  void DrawFrame();
  void DrawLive(const CaptureState& state, const Panels& panels);
  void DrawSubjectTool(const CaptureState& state, const Panels& panels);
  void DrawReview(const CaptureState& state, const Panels& panels);
  unsigned PictureInReview(const CaptureState& state, const Review::VirtualCamera& virtual_camera);
  std::vector<render::TableRow> ReviewRows(const CaptureState& state,
                                           const std::optional<Review::VirtualCamera>& virtual_camera) const;
  const Palette& palette() const { return colour_blind_ ? Palette::ForColourBlind() : Palette::Standard(); }

  render::Surface& surface_;
  CaptureFeed& feed_;
  const DisplayOptions options_;
  PendingRequests pending_;
  render::Painter painter_;
  render::LiveTexture live_;
  Reprojection reprojection_;
  SpreadPictures spread_;
  RecordedPictures recorded_;
  RenderedReview rendered_;
  SubjectTool subject_tool_;
  Review review_;

  std::shared_ptr<const CaptureState> state_;
  bool state_is_new_ = false;
  render::Placement placement_;
  std::optional<int> marked_view_;  // on the screen, in review
  double marked_at_s_ = 0;          // when it was first shown

  bool is_rendered_ = false;  // the review's last picture, by the renderer

  bool done_ = false;
  bool over_ = false;  // the capture has ended
  bool colour_blind_ = false;
  bool keys_shown_ = false;
  bool legend_shown_ = true;
  SphereLayer layer_ = SphereLayer::kCoverage;
  bool close_look_shown_ = true;
  std::optional<bool> preflight_shown_;  // none: until the first view
  bool sound_ = false;
  bool was_in_rectangle_ = true;
  double now_s_ = 0;  // of this picture
  struct Said {
    std::string words;
    double at_s = 0;
  };
  std::deque<Said> said_;         // on the screen
  std::uint64_t times_said_ = 0;  // by the capture, up to the last state
  bool preflight_seen_ = false;
  std::optional<double> preflight_until_s_, flash_until_s_;
};

}  // namespace ulf::coverage
