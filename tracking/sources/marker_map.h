// Where markers of known size are, learnt while they are seen: a small bundle adjustment of its own.
//
// World: the first marker's frame, metres. A frame that shows a marker without a place beside one that has
// it proposes one; several that agree make it known. From then on frames spread over the views (keyframes)
// are kept, and marker and camera poses are refined together over all their corners (Gauss-Newton on camera
// and marker in turn, each with the other held, which converges because every corner is seen with its
// camera's others).
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "core/fiducials/marker_corners.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

class MarkerMap {
 public:
  MarkerMap(const CameraModel& camera, double side_m) : camera_(camera), side_m_(side_m) {}

  bool Knows(int id) const { return world_from_marker_.contains(id); }
  int Size() const { return static_cast<int>(world_from_marker_.size()); }
  // The world is this marker's frame.
  void Begin(int id) {
    world_from_marker_[id] = {};
    first_ = id;
  }
  // The known markers' corners with their places.
  std::vector<PointObservation> Corners(const std::map<int, MarkerImage>& seen, double sigma_px) const;
  // A frame whose camera is known; `cam_from_marker` of markers without a place, where there is no doubt.
  void Add(const Rigid3& cam_from_world, const std::map<int, MarkerImage>& seen,
           const std::map<int, Rigid3>& cam_from_new);
  int First() const { return first_; }  // the world's; -1: none yet
  const std::map<int, Rigid3>& WorldFromMarker() const { return world_from_marker_; }

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
