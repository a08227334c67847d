// The viewer's state: the camera and the enabled options. ViewerInput turns input into a state, without side
// effects; actions that need more (a file, a depth, the window) become requests.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/display/plain_panels.h"
#include "render/display/surface.h"
#include "render/fields/aperture.h"
#include "render/fields/field_options.h"
#include "render/viewer/viewer_camera.h"

namespace ulf::render {

struct ViewerState {
  ViewerCamera camera;
  FieldOptions field;  // as the user selected it
  int proxy = 0;       // index into ViewerOptions::proxies
  double exposure_stops = 0;
  double aperture = 0;  // radius of the lens, world units; 0: closed, everything is in focus
  Eigen::Vector3d focus_in_world = Eigen::Vector3d::Zero();
  bool shows_field = false;  // a colour for each view instead of its photograph (thesis, figure 5-1)
  bool shows_mesh = false;   // the viewpoint mesh (thesis, figure 5-3)
  bool shows_gizmo = true;   // ViewpointGizmo
  bool shows_doubt = false;  // stripes where confidence is low
  bool shows_texts = true;
  bool shows_keys = false;
  bool operator==(const ViewerState&) const = default;

  std::optional<Aperture> OpenAperture() const;  // none if it is closed
};

struct ViewerRequest {
  enum What { kLeave, kFullScreen, kScreenshot, kKeyframe, kNearestView, kFocus };
  What what;
  Eigen::Vector2d img = {};  // for kFocus: the pixel
};

class ViewerInput {
 public:
  // `proxies` is their number. `least_aperture` is the distance of neighbouring viewpoints, world units; a
  // smaller aperture has no effect (aperture.h).
  ViewerInput(const ViewerState& start, int proxies, double least_aperture)
      : state_(start), start_(start.camera), proxies_(proxies), least_aperture_(least_aperture) {}

  void Handle(const InputEvent& event, const cv::Size& screen);
  const ViewerState& state() const { return state_; }
  std::vector<ViewerRequest> TakeRequests();
  void Place(const ViewerCamera& camera) { state_.camera = camera; }
  void SelectProxy(int proxy) { state_.proxy = proxy; }
  void Focus(const Eigen::Vector3d& focus_in_world) { state_.focus_in_world = focus_in_world; }
  void Open(const Aperture& aperture);

 private:
  void Press(const KeyPressed& key);
  void Type(char32_t character, const cv::Size& screen);
  void Turn(const WheelTurned& wheel);
  void Click(const MouseButton& button);
  void Move(const Eigen::Vector2d& to, const cv::Size& screen);
  void Drag(const Eigen::Vector2d& by, const cv::Size& screen);
  void Widen(double steps);
  void FocusFarther(double steps);
  void Request(ViewerRequest::What what, const Eigen::Vector2d& img = Eigen::Vector2d::Zero()) {
    requests_.push_back({what, img});
  }
  ViewerState state_;
  ViewerCamera start_;
  int proxies_;
  double least_aperture_;
  double last_aperture_ = 0;  // before the lens was closed
  std::vector<ViewerRequest> requests_;
  Eigen::Vector2d mouse_ = Eigen::Vector2d::Zero(), pressed_at_ = Eigen::Vector2d::Zero();
  std::optional<int> pressed_;  // which button
  bool dragging_ = false;       // the mouse has moved since the press, which is no click
};

inline constexpr KeyHelp kViewerKeys[] = {{"arrows, left drag", "round the subject"},
                                          {"Shift arrows, right drag", "sideways"},
                                          {"PgUp PgDn, wheel", "nearer, farther"},
                                          {"+ -, Shift wheel", "zoom the lens"},
                                          {"N", "to the nearest recorded viewpoint"},
                                          {"Home", "back to the first view"},
                                          {"F, 1 to 6", "blending field"},
                                          {"L", "level of subdivision"},
                                          {"P", "proxy"},
                                          {"O I, Ctrl wheel", "aperture wider, narrower"},
                                          {"X", "aperture closed, open"},
                                          {"click, R", "focus there, in the middle"},
                                          {"U J", "focus farther, nearer"},
                                          {"B", "the field in a colour for each view"},
                                          {"M", "mesh of the viewpoints"},
                                          {"C", "stripes where confidence is low"},
                                          {"W", "where the camera is"},
                                          {"E D", "brighter, darker"},
                                          {"T", "texts"},
                                          {"S", "picture to a file"},
                                          {"K", "keyframe to a file"},
                                          {"G or F11", "full screen"},
                                          {"?", "these keys"},
                                          {"Q", "leave"}};

// The fields that keys 1 to 6 select.
inline constexpr FieldKind kViewerFields[] = {FieldKind::kSubdivision, FieldKind::kLinear,
                                              FieldKind::kLumigraph,   FieldKind::kLumigraphPerPixel,
                                              FieldKind::kNearest,     FieldKind::kSoft};

// The values in the texts of the viewer.
struct ViewerFigures {
  std::size_t views = 0;
  FieldOptions field;  // in use, which may differ from the selected one
  std::string proxy;
  double focus_depth = 0;               // of the focal plane, along the optical axis, world units
  std::optional<double> f_number = {};  // of the aperture, if world units are metres
  bool loading = false;                 // photographs of this picture are still being read
  cv::Size drawn_size = {};             // of the light field if it differs from the window's, else empty
  double frame_ms = 0;                  // time of the last frame; 0: none yet
  double picture_ms = 0;                // the light field's part of this time
};

std::vector<StatusItem> StatusLine(const ViewerState& state, const ViewerFigures& figures);

}  // namespace ulf::render
