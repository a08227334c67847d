// Learns the places of markers of known size while they are seen, by a small bundle adjustment.
//
// The world is the first marker's frame, in metres. A frame that shows a marker without a place beside one
// with a place proposes a place; several proposals that agree make it known. From then on the map keeps
// frames that are spread over the views (keyframes) and refines marker and camera poses over all their
// corners: Gauss-Newton on cameras and markers in turn, each with the other held. That converges because
// every camera sees several corners.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/fiducials/marker_detector.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

class MarkerMap {
 public:
  // `side_m` is the side of every marker's black square.
  MarkerMap(const CameraModel& camera, double side_m) : camera_(camera), side_m_(side_m) {}

  bool Knows(int id) const { return world_from_marker_.contains(id); }  // whether marker `id` has a place
  int Size() const { return static_cast<int>(world_from_marker_.size()); }
  // Makes this marker's frame the world.
  void Begin(int id) {
    world_from_marker_[id] = {};
    first_ = id;
  }
  // Returns the known markers' corners with their positions in the world.
  std::vector<PointObservation> Corners(const std::map<int, MarkerImage>& seen, double sigma_px) const;
  // Adds a frame with a known pose. `cam_from_new`: unambiguous poses of markers without a place.
  void Add(const Rigid3& cam_from_world, const std::map<int, MarkerImage>& seen,
           const std::map<int, Rigid3>& cam_from_new);
  int First() const { return first_; }  // the marker whose frame is the world; -1: none yet

 private:
  struct Keyframe {
    Rigid3 cam_from_world;
    std::map<int, MarkerImage> seen;
  };
  void Adjust(int rounds);

  CameraModel camera_;
  double side_m_;
  std::map<int, Rigid3> world_from_marker_;
  std::map<int, std::vector<Rigid3>> proposed_;
  std::vector<Keyframe> keyframes_;
  int first_ = -1;
};

}  // namespace ulf::tracking
