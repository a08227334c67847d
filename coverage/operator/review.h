// Reviews the recorded views while the capture goes on (thesis, section 3.2): moves the virtual camera by
// mouse and keys, by the live camera, or by a marker in front of it. When the subject is moved the virtual
// camera stays where it is and turns to the new place.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "coverage/operator/marker_mouse.h"
#include "coverage/operator/overlay.h"
#include "coverage/operator/pending_requests.h"
#include "coverage/session/capture_state.h"
#include "render/display/surface.h"

namespace ulf::tracking {
class MarkerLocator;
}  // namespace ulf::tracking

namespace ulf::coverage {

class Review {
 public:
  enum class Control { kLiveCamera, kMouseAndKeys, kMarker };
  enum class Compare { kNone, kWipe, kBlink };  // against the live picture; only from the live camera

  // `marker`: what is held before the camera, parsed by MarkerSpec, which may throw Refusal; empty: none.
  explicit Review(std::string marker = "");
  ~Review();

  bool is_open() const { return open_; }
  Control control() const { return control_; }
  Compare compare() const { return compare_; }
  double wipe() const { return wipe_; }  // left of this share of the width the live picture is shown
  bool marker_is_seen() const { return marker_is_seen_; }

  void Open(const CaptureState& state);
  // Returns true when the review used the event, which may close it.
  bool Handle(const render::InputEvent& event, const CaptureState& state);

  struct VirtualCamera {
    CameraModel camera;
    Rigid3 cam_from_world;
  };
  // Returns the review's camera for this state; none: the chosen control has no pose.
  std::optional<VirtualCamera> CameraNow(const CaptureState& state);

 private:
  // A viewpoint around the subject, in the coverage map's own angles.
  struct Orbit {
    Subject subject;
    CapFrame frame;
    double azimuth = 0, elevation = 0, distance = 1;
    Eigen::Vector3d Center() const;
  };
  static std::optional<Orbit> OrbitAt(const CaptureState& state, const Eigen::Vector3d& center_in_world);
  void StartOrbit(const CaptureState& state);
  void FollowSubject(const CaptureState& state);
  void Turn(double azimuth, double elevation);
  void Zoom(double factor);
  void NextControl(const CaptureState& state);
  void ToggleCompare(Compare compare);
  std::optional<Rigid3> MarkerPose(const CaptureState& state);

  std::string marker_;
  bool open_ = false;
  Control control_ = Control::kLiveCamera;
  Compare compare_ = Compare::kNone;
  double wipe_ = 0.5;
  std::optional<Orbit> orbit_;  // none: nothing to go round yet
  std::optional<Eigen::Vector2d> mouse_;
  bool dragging_ = false;

  std::unique_ptr<tracking::MarkerLocator> locator_;
  CameraModel lens_;                       // of locator_
  std::optional<Rigid3> cam_from_marker_;  // as it was last seen
  double located_at_s_ = -1;
  bool marker_is_seen_ = false;
  std::optional<Subject> mouse_subject_;  // that the marker moves
  std::optional<MarkerMouse> marker_mouse_;
};

// The recorded view nearest in direction to the review's camera, as seen from the subject: the one that the
// Delete key takes back.
struct MarkedView {
  int id = 0;
  render::Overlay shapes;  // in the camera's picture, where the view's direction meets the subject's sphere
};
// Marks a view among those that no pending request takes back. Returns none when there is no such view.
std::optional<MarkedView> MarkNearestView(const CaptureState& state, const PendingRequests& pending,
                                          const CameraModel& camera, const Rigid3& cam_from_world,
                                          const Palette& palette);

}  // namespace ulf::coverage
