// Looking at what has been recorded so far while the capture goes on (thesis, section 3.2): the virtual
// camera, moved by mouse and keys, by the live camera, or by a marker before it; and which recorded pictures
// it sees. Pure but for the marker's detector.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coverage/capture_state.h"
#include "coverage/marker_mouse.h"
#include "coverage/operator/posed_pictures.h"
#include "coverage/operator/reprojection.h"
#include "coverage/operator/surface.h"

namespace ulf {

class MarkerLocator;

class Review {
 public:
  enum class Control { kLiveCamera, kMouseAndKeys, kMarker };
  enum class Compare { kNone, kWipe, kBlink };  // against the live picture; only from the live camera

  // `marker`: what is held before the camera (see 'ulf review'); empty: none.
  explicit Review(std::string marker = "");
  ~Review();

  bool is_open() const { return open_; }
  Control control() const { return control_; }
  Compare compare() const { return compare_; }
  double wipe() const { return wipe_; }  // left of this share of the width: live
  bool marker_is_seen() const { return marker_is_seen_; }

  void Open(const CaptureState& state);
  bool Handle(const InputEvent& event, const CaptureState& state);

  // Where it is looked from, and with which camera; none: the chosen control has no pose.
  struct VirtualCamera {
    CameraModel camera;
    Rigid3 cam_from_world;
  };
  std::optional<VirtualCamera> CameraNow(const CaptureState& state);

  // The recorded pictures nearest in direction, with weights that fall to 0 at the first one left out.
  static std::vector<WeightedPicture> Nearest(const std::map<int, PosedPicture>& pictures,
                                              const Eigen::Vector3d& subject_in_world,
                                              const Rigid3& cam_from_world);

 private:
  void StartOrbit(const CaptureState& state);
  void Orbit(double azimuth, double elevation);
  std::optional<Rigid3> OrbitPose(const CaptureState& state) const;
  std::optional<Rigid3> MarkerPose(const CaptureState& state);

  std::string marker_;
  bool open_ = false;
  Control control_ = Control::kLiveCamera;
  Compare compare_ = Compare::kNone;
  double wipe_ = 0.5;
  double azimuth_ = 0, elevation_ = 0, distance_ = 1;  // of the orbit, about its frame
  std::optional<CapFrame> orbit_frame_;
  std::optional<Eigen::Vector2d> mouse_;
  bool dragging_ = false;

  std::unique_ptr<MarkerLocator> locator_;
  std::optional<MarkerMouse> marker_mouse_;
  std::optional<Rigid3> marker_pose_;
  double located_at_s_ = -1;
  bool marker_is_seen_ = false;
};

}  // namespace ulf
