// What the person with the camera sees and presses (thesis, section 3.2): the live picture with the overlay,
// a status line, the subject tool with its augmented aperture, and the review. Draws the newest state of a
// capture and nothing else; whatever is asked of the capture is a CaptureRequest, so that a capture without a
// display can be asked the same.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coverage/capture_request.h"
#include "coverage/operator/live_texture.h"
#include "coverage/operator/painter.h"
#include "coverage/operator/posed_pictures.h"
#include "coverage/operator/reprojection.h"
#include "coverage/operator/review.h"
#include "coverage/operator/subject_tool.h"
#include "coverage/operator/surface.h"

namespace ulf {

struct DisplayOptions {
  std::string marker;  // held before the camera to look round in review; empty: none
  bool colour_blind = false;
};

class OperatorDisplay {
 public:
  OperatorDisplay(Surface& surface, CaptureFeed& feed, CaptureRequests& requests,
                  const DisplayOptions& options = {});

  // Takes what has been pressed and draws the newest state. False once the window has been asked to close or
  // the capture to finish.
  bool Step(double patience_s = 0);

 private:
  void Handle(const InputEvent& event);
  bool HandleInAnyMode(const InputEvent& event);
  void TakeStates();
  void DrawFrame();
  void DrawLive(const CaptureState& state);
  void DrawSubjectTool(const CaptureState& state);
  void DrawReview(const CaptureState& state);
  void DrawStatus(const CaptureState& state);
  void DrawSaid();
  void DrawShare(const CaptureState& state);
  void DrawTrackingHelp(const CaptureState& state);
  void DrawInstruction(const std::string& words, const Rgba& color);
  void DrawLegend(const CaptureState& state);
  void DrawCloseLook(const CaptureState& state);
  void DrawPreflight(const CaptureState& state);
  void DrawKeys();
  void DrawHint(const std::string& words);
  struct Row {
    std::optional<Rgba> swatch;
    std::string left = {}, right = {};
    Rgba color{235, 235, 235};
  };
  cv::Rect2d DrawTable(const std::vector<Row>& rows, const Eigen::Vector2d& corner,
                       const Eigen::Vector2d& anchor, double wrap_points = 0);
  double Px(double points) const { return points * scale_; }
  const Palette& palette() const { return colour_blind_ ? Palette::ForColourBlind() : Palette::Standard(); }

  Surface& surface_;
  CaptureFeed& feed_;
  CaptureRequests& requests_;
  Painter painter_;
  LiveTexture live_;
  Reprojection reprojection_;
  SpreadPictures spread_;
  RecordedPictures recorded_;
  SubjectTool subject_tool_;
  Review review_;

  std::shared_ptr<const CaptureState> state_;
  bool state_is_new_ = false;
  cv::Size screen_;
  double scale_ = 1;
  Placement placement_;

  bool done_ = false;
  bool colour_blind_ = false;
  bool keys_shown_ = false;
  bool legend_shown_ = true;
  bool close_look_shown_ = true;
  std::optional<bool> preflight_shown_;  // none: until the first view
  bool sound_ = false;
  bool was_held_ = true;
  int frames_ = 0;
  std::string said_;  // by the capture, last
  int said_at_frame_ = 0;
};

}  // namespace ulf
