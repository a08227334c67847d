// The tracker's world: keyframes and the points they see, as values with ids.
//
// Keyframes are numbered as they come. A removed one leaves its pose relative to a surviving one behind, so
// that what was anchored to it stays meaningful; all else of it is freed. A point's number is given again
// when the point has been dead for kPointRest keyframes, so the map is as large as what lives in it however
// long the camera runs; until then a merged point says into which. World units are arbitrary; observations
// are level 0 pixels with centres at integer + 0.5. SharedMap says which thread may read and change it when.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/features/features.h"
#include "tracking/features/patch_alignment.h"
#include "tracking/map/anchored.h"

namespace ulf::tracking {

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
  std::vector<ViewObservation> views;  // that were recorded and show it, one each; most are no keyframes
  int first_keyframe = -1;             // newest keyframe when it was made
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
  // Of a removed keyframe: this keyframe's pose relative to a living one.
  int parent = -1;
  Rigid3 cam_from_parent;
  std::vector<int> children;  // of a living one: the removed ones that hang on it
  std::shared_ptr<const FeatureSet> features;
  std::shared_ptr<const Pyramid> pyramid;  // of recent keyframes only
  // Of a rolling shutter: by which features and observations were brought to the frame's time.
  std::shared_ptr<const RowShift> rows;
  std::optional<Twist> velocity;  // as the frames before and after show it
  cv::Mat color;                  // 8 bits, B G R or grey; of recent keyframes only
  bool pinned = false;            // its pose is given (a seed): never adjusted, never removed
  // Of a world that is given, where this frame saw them (fiducial_observation.h).
  std::vector<PointObservation> corners = {};
  std::vector<int> point_of_feature;  // -1: none
  int points = 0;                     // features with a point
  int points_at_birth = 0;            // those that were tracked when it was made
};

class Map {
 public:
  explicit Map(const CameraModel& camera) : camera_(camera) {}

  int AddKeyframe(Keyframe keyframe);  // returns its id; observations are added one by one
  int AddPoint(const Eigen::Vector3d& position);
  // False when either already has another partner there.
  bool Observe(int point, const Observation& observation);
  // A recorded view shows it; only the first time counts.
  void SeenInView(int point, const ViewObservation& seen);
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
  const std::vector<int>& living() const { return living_; }  // keyframes, in order of their numbers
  int FirstKeyframe() const { return living_.empty() ? -1 : living_.front(); }
  int LivingKeyframes() const { return static_cast<int>(living_.size()); }
  int LivingPoints() const { return living_points_; }
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

  // Descriptor, mean direction, distances and patch axes, after observations changed.
  void Update(int point);
  // All of it but the descriptor: after positions or poses changed.
  void UpdateGeometry(int point);
  // Cuts the point's reference patch out of a keyframe that still has its pyramid.
  void SetPatch(int point, const Observation& from);

  // Discards the world: everything dead, poses frozen where they are.
  void Clear();

  // Dead points keep their number for this many keyframes: longer than anybody remembers one.
  static constexpr int kPointRest = 20;

 private:
  void UpdateDescriptor(MapPoint& point);

  CameraModel camera_;
  std::vector<Keyframe> keyframes_;
  std::vector<int> living_;
  std::vector<MapPoint> points_;
  int living_points_ = 0;
  struct Free {
    int point;
    int keyframes;  // how many there had been when it died
  };
  std::deque<Free> free_;
};

// Of a rolling shutter (readout_estimator.h).
struct ReadoutEstimate {
  double readout_s = 0;  // from the first row to the last; negative: read from the last
  double sigma_s = 0;
  int keyframes = 0;
};

// One thread changes the map: the mapper's, or the tracker's while the mapper rests. It takes the lock
// (MapLock) for every change and reads without it; every other thread takes it to read.
struct SharedMap {
  explicit SharedMap(const CameraModel& camera) : map(camera) {}
  // For the thread that changes the map. Not analysed: that no other thread changes it is what makes reading
  // without the lock safe, and the analysis knows no threads.
  const Map& ReadByOwner() const ULF_NO_THREAD_SAFETY_ANALYSIS { return map; }

  mutable Mutex mutex;
  Map map ULF_GUARDED_BY(mutex);
  std::atomic<std::thread::id> owner{};  // the mapper's thread
  // That any other thread waited for the lock.
  mutable std::chrono::steady_clock::duration longest_wait ULF_GUARDED_BY(mutex){};
  std::atomic<int> loops{0};  // closed so far
  // The world is the one that corners are given in.
  std::atomic<bool> world_given{false};
  // Counts corrections that move much at once: who keeps poses should ask for them again.
  std::atomic<int> revision{0};
  // Whether the mapper shall measure the readout when it has adjusted everything, how often it did, and what
  // came out last.
  std::atomic<bool> measure_readout{false};
  std::atomic<int> readouts_measured{0};
  std::optional<ReadoutEstimate> readout ULF_GUARDED_BY(mutex);
};

// Holds the map's lock, and measures how long any thread but the mapper's waited for it.
class ULF_SCOPED_CAPABILITY MapLock {
 public:
  explicit MapLock(const SharedMap& shared) ULF_ACQUIRE(shared.mutex) : mutex_(shared.mutex) {
    if (mutex_.try_lock()) return;
    const auto start = std::chrono::steady_clock::now();
    mutex_.lock();
    if (std::this_thread::get_id() != shared.owner)
      shared.longest_wait = std::max(shared.longest_wait, std::chrono::steady_clock::now() - start);
  }
  ~MapLock() ULF_RELEASE() { mutex_.unlock(); }
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  Mutex& mutex_;
};

}  // namespace ulf::tracking
