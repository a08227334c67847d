// The tracker's world: keyframes and the points they see, as values with ids.
//
// Points and keyframes are numbered as they come and never renumbered. A removed keyframe leaves its pose
// relative to a surviving one behind, so that what was anchored to it stays meaningful; a merged point says
// into which. World units are arbitrary; observations are level 0 pixels with centres at integer + 0.5. One
// thread changes the structure (the mapper, or the tracker while the mapper rests); SharedMap::mutex is held
// for every change, and by every other thread for reading.
#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "acquisition/camera_model.h"
#include "acquisition/rigid3.h"
#include "tracking/anchored.h"
#include "tracking/features.h"
#include "tracking/patch_alignment.h"

namespace ulf {

struct Observation {
  int keyframe = -1;
  int feature = -1;
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // aligned with the point's patch where that worked
  double sigma_px = 1;
};

// Errors of a feature as detected, and of one aligned with the point's patch, on a level.
inline double DetectedSigmaPx(int level) { return 1.0 * LevelScale(level); }
inline double AlignedSigmaPx(int level) { return 0.4 * LevelScale(level); }

struct MapPoint {
  int id = -1;
  bool alive = true;
  int merged_into = -1;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<Observation> observations;
  int first_keyframe = -1;  // newest keyframe when it was made
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
  // How often frames expected to see it, and did.
  int expected = 0;
  int found = 0;
  // Derived by Map::Update from the observations:
  Descriptor descriptor{};
  Eigen::Vector3d mean_direction = Eigen::Vector3d::Zero();  // unit, from the viewing cameras to the point
  double reference_distance = 0;                             // distance at which it looks as on level 0
  double nearest = 0, farthest = 0;  // distances at which the pyramid can still show it
  std::shared_ptr<const ReferencePatch> patch;
  int patch_keyframe = -1;
  PatchAxes patch_axes = PatchAxes::Zero();
};

struct Keyframe {
  int id = -1;
  bool alive = true;
  double time_s = 0;
  Rigid3 cam_from_world;
  // How much lengths about it have been scaled by closed loops since it was made.
  double unit = 1;
  // Of a removed keyframe: this keyframe's pose relative to another.
  int parent = -1;
  Rigid3 cam_from_parent;
  std::shared_ptr<const FeatureSet> features;
  std::shared_ptr<const Pyramid> pyramid;  // of recent keyframes only
  cv::Mat color;                           // 8 bits, B G R or grey; of recent keyframes only
  bool pinned = false;                     // its pose is given (a seed): never adjusted, never removed
  std::vector<int> point_of_feature;       // -1: none
  int points = 0;                          // features with a point
  int points_at_birth = 0;                 // those that were tracked when it was made
};

class Map {
 public:
  explicit Map(const CameraModel& camera) : camera_(camera) {}

  int AddKeyframe(Keyframe keyframe);  // returns its id; observations are added one by one
  int AddPoint(const Eigen::Vector3d& position);
  // False when either already has another partner there.
  bool Observe(int point, const Observation& observation);
  void Forget(int point, int keyframe);  // removes an observation; a point with fewer than two goes
  void RemovePoint(int point);
  void Merge(int gone, int kept);     // moves what observations it can
  void RemoveKeyframe(int keyframe);  // never the first

  const Keyframe& keyframe(int id) const { return keyframes_[static_cast<std::size_t>(id)]; }
  Keyframe& keyframe(int id) { return keyframes_[static_cast<std::size_t>(id)]; }
  const MapPoint& point(int id) const { return points_[static_cast<std::size_t>(id)]; }
  MapPoint& point(int id) { return points_[static_cast<std::size_t>(id)]; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<MapPoint>& points() const { return points_; }
  int FirstKeyframe() const;  // the oldest living one, which holds the world in place; -1 without any
  int LivingKeyframes() const;
  int LivingPoints() const;
  // The point that `id` has become; -1 when it is gone.
  int Resolve(int id) const;

  // Follows removed keyframes to living ones.
  Rigid3 PoseOf(int keyframe) const;
  Rigid3 PoseOf(const Anchored& anchor) const;

  struct Neighbour {
    int keyframe;
    int shared;  // points seen by both
  };
  // Keyframes that share at least `min_shared` points, most first.
  std::vector<Neighbour> Covisible(int keyframe, int min_shared = 15) const;

  // Descriptor, mean direction, distances and patch axes, after observations or poses changed.
  void Update(int point);
  // Cuts the point's reference patch out of a keyframe that still has its pyramid.
  void SetPatch(int point, const Observation& from);

  // Discards the world: everything dead, poses frozen where they are.
  void Clear();

 private:
  CameraModel camera_;
  std::vector<Keyframe> keyframes_;
  std::vector<MapPoint> points_;
};

struct SharedMap {
  explicit SharedMap(const CameraModel& camera) : map(camera) {}
  mutable std::mutex mutex;
  Map map;
  std::atomic<int> loops{0};  // closed so far
  // Counts corrections that move much at once: who keeps poses should ask for them again.
  std::atomic<int> revision{0};
};

}  // namespace ulf
