// What the viewer's person has switched and where they stand: input in, state out. Pure: what needs more than
// that (a file, a depth, the window) comes out as a request.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "render/display/plain_panels.h"
#include "render/display/surface.h"
#include "render/fields/aperture.h"
#include "render/fields/blending_field.h"
#include "render/viewer/viewer_camera.h"

namespace ulf::render {

struct ViewerState {
  ViewerCamera camera;
  FieldOptions field;  // as asked
  int proxy = 0;       // of those that there are
  double exposure_stops = 0;
  double aperture = 0;  // radius of the lens, world units; 0: closed, everything is as sharp as the proxy
  Eigen::Vector3d focus_in_world = Eigen::Vector3d::Zero();
  bool shows_field = false;  // a colour for each view (thesis, figure 5-1)
  bool shows_mesh = false;   // of the viewpoints (figure 5-3)
  bool shows_where = true;
  bool shows_doubt = false;
  bool shows_words = true;
  bool shows_keys = false;
  bool operator==(const ViewerState&) const = default;

  std::optional<Aperture> OpenAperture() const;
};

struct ViewerRequest {
  enum What { kLeave, kFullScreen, kScreenshot, kKeyframe, kNearestView, kFocus };
  What what;
  Eigen::Vector2d img = {};  // of kFocus: on what
};

class ViewerInput {
 public:
  // Less than `least_aperture`, how far viewpoints are apart, is no lens (aperture.h).
  ViewerInput(const ViewerState& start, int proxies, double least_aperture)
      : state_(start), start_(start.camera), proxies_(proxies), least_aperture_(least_aperture) {}

  void Handle(const InputEvent& event, const cv::Size& screen);
  const ViewerState& state() const { return state_; }
  std::vector<ViewerRequest> TakeRequests();
  void Place(const ViewerCamera& camera) { state_.camera = camera; }
  void TakeProxy(int proxy) { state_.proxy = proxy; }
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
  double last_aperture_ = 0;  // that was open
  std::vector<ViewerRequest> requests_;
  Eigen::Vector2d mouse_ = Eigen::Vector2d::Zero(), pressed_at_ = Eigen::Vector2d::Zero();
  std::optional<int> pressed_;  // which button
  bool dragging_ = false;       // it has moved since: no click any more
};

inline constexpr KeyHelp kViewerKeys[] = {{"arrows, left drag", "round the subject"},
                                          {"Shift arrows, right drag", "sideways"},
                                          {"PgUp PgDn, wheel", "nearer, farther"},
                                          {"+ -, Shift wheel", "zoom the lens"},
                                          {"N", "to the nearest recorded viewpoint"},
                                          {"Home", "back to where it began"},
                                          {"F, 1 to 5", "blending field"},
                                          {"L", "level of subdivision"},
                                          {"P", "proxy"},
                                          {"O I, Ctrl wheel", "aperture wider, narrower"},
                                          {"X", "aperture closed, open"},
                                          {"click, R", "focus there, on the middle"},
                                          {"U J", "focus farther, nearer"},
                                          {"B", "the field in a colour for each view"},
                                          {"M", "mesh of the viewpoints"},
                                          {"C", "stripes where confidence is low"},
                                          {"W", "where am I"},
                                          {"E D", "brighter, darker"},
                                          {"T", "words"},
                                          {"S", "picture to a file"},
                                          {"K", "keyframe to a file"},
                                          {"G or F11", "full screen"},
                                          {"?", "these keys"},
                                          {"Q", "leave"}};

// The fields of keys 1 to 5.
inline constexpr FieldKind kViewerFields[] = {FieldKind::kSubdivision, FieldKind::kLinear,
                                              FieldKind::kLumigraph, FieldKind::kLumigraphPerPixel,
                                              FieldKind::kNearest};

}  // namespace ulf::render
