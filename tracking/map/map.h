// Holds the tracker's map: keyframes and the points they see, as values with ids.
//
// Keyframes are numbered as they come. A removed keyframe keeps its pose relative to a living one, so that
// poses anchored to it stay valid; the rest of it is freed. The id of a removed point is used again after
// kPointReuseKeyframes keyframes, so that the map does not grow with time; until then a merged point names
// the point it was merged into. World units are arbitrary; observations are level 0 pixels with centres at
// integer + 0.5. Map is not synchronised; SharedMap and OwnedMap say who may read and who may change it.
//
// A camera that stays lost begins another part of the map: keyframes and points with a world of their own,
// until the loop closer finds how the parts lie to each other and joins them. The main part's world is the
// one that users see.
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
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/at.h"
#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/calibration_check.h"
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

struct MapPoint {
  int id = -1;
  bool alive = true;
  int part = 0;
  int merged_into = -1;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<Observation> observations;
  std::vector<ViewObservation> views;  // recorded views that show it, one each; most are no keyframes
  int first_keyframe = -1;             // the newest keyframe when the point was made
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
  // Frames that should have shown it, and frames in which it was found.
  int expected = 0;
  int found = 0;
  // Derived by Map::Update from the observations:
  Descriptor descriptor{};
  Eigen::Vector3d mean_direction = Eigen::Vector3d::Zero();  // unit, from the viewing cameras to the point
  double parallax = 0;               // about the angle between its outermost viewing directions, radians
  double reference_distance = 0;     // distance from which level 0 shows it as it was seen
  double nearest = 0, farthest = 0;  // distances at which the pyramid can show it
  std::shared_ptr<const ReferencePatch> patch;
  int patch_keyframe = -1;
  PatchAxes patch_axes = PatchAxes::Zero();
};

struct Keyframe {
  int id = -1;
  bool alive = true;
  int part = 0;
  double time_s = 0;
  Rigid3 cam_from_world;
  // The factor by which closed loops have scaled the lengths around the keyframe since it was made.
  double unit = 1;
  // A removed keyframe's pose relative to a living one.
  int parent = -1;
  Rigid3 cam_from_parent;
  std::vector<int> children;  // of a living one: the removed ones whose parent it is
  std::shared_ptr<const FeatureSet> features;
  std::shared_ptr<const Pyramid> pyramid;  // of recent keyframes only
  // The rolling shutter's motion that was removed from features and observations; null: none was.
  std::shared_ptr<const RowShift> rows;
  std::optional<Twist> expected_twist;  // of the rows, from the tracker: adjustments hold it to this one
  std::optional<Twist> velocity;        // from the frames before and after
  cv::Mat color;                        // 8 bits, B G R or grey; of recent keyframes only
  bool pinned = false;                  // its pose is given (a seed): never adjusted, never removed
  // Corners of a given world that this frame saw, where the sensor saw them (fiducial_observation.h).
  std::vector<PointObservation> corners = {};
  std::vector<int> point_of_feature;  // -1: none
  int points = 0;                     // features with a point
  int points_at_birth = 0;            // features with a point when it was made
};

class Map {
 public:
  explicit Map(const CameraModel& camera) : camera_(camera) {}

  // Replaces the lens by another of the same image size: image points stay, the features' rays change.
  void SetCamera(const CameraModel& camera);
  int AddKeyframe(Keyframe keyframe);  // returns its id; observations are added one by one
  int AddPoint(const Eigen::Vector3d& position, int part = 0);
  // Returns false when the feature has a point, or the keyframe observes the point, already.
  bool AddObservation(int point, const Observation& observation);
  // Adds a recorded view that shows the point, unless the point has it already.
  void AddView(int point, const ViewObservation& seen);
  void RemoveObservation(int point, int keyframe);  // removes the point, too, when fewer than two are left
  void RemovePoint(int point);
  // Moves the observations that `kept` can take, and returns them as they are there.
  std::span<Observation> Merge(int gone, int kept);
  void RemoveKeyframe(int keyframe);  // the last living one of its part stays

  int BeginPart() { return next_part_++; }  // returns its number; numbers are not used again
  // Keyframes and points of `gone` count as `kept`'s from now on. The caller has moved them into its world.
  void JoinPart(int gone, int kept);
  // Removes all points and keyframes of a part; PoseOf() keeps their last poses.
  void RemovePart(int part);
  void SetMainPart(int part) { main_part_ = part; }
  int main_part() const { return main_part_; }
  std::vector<int> Parts() const;  // with living keyframes, by number

  const Keyframe& keyframe(int id) const { return keyframes_[At(id)]; }
  Keyframe& keyframe(int id) { return keyframes_[At(id)]; }
  const MapPoint& point(int id) const { return points_[At(id)]; }
  MapPoint& point(int id) { return points_[At(id)]; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<MapPoint>& points() const { return points_; }
  const std::vector<int>& living() const { return living_; }  // keyframes, in order of their numbers
  std::vector<int> LivingOf(int part) const;
  int FirstKeyframe(int part) const;  // living; -1: none
  int LivingKeyframes() const { return static_cast<int>(living_.size()); }
  int LivingPoints() const { return living_points_; }
  // Returns the point that `id` was merged into, or `id` itself; -1 when it is gone.
  int Resolve(int id) const;

  // Return the present poses of keyframes, removed ones included, and of anchors.
  Rigid3 PoseOf(int keyframe) const;
  Rigid3 PoseOf(const Anchored& anchor) const;
  // Returns the points that a keyframe sees, in the order of its features.
  std::vector<int> PointsSeenBy(int keyframe) const;
  // Returns the points that any of these keyframes sees, each once, by id.
  std::vector<int> PointsSeenBy(std::span<const int> keyframes) const;
  // Returns the median depth of the points that a keyframe sees, along its optical axis; 1 without points.
  double MedianDepth(int keyframe) const;

  struct Neighbour {
    int keyframe;
    int shared;  // points seen by both
  };
  // Returns the keyframes that share at least `min_shared` points, most first.
  std::vector<Neighbour> Covisible(int keyframe, int min_shared = 15) const;

  // Derives descriptor, mean direction, distances and patch axes anew: after observations changed.
  void Update(int point);
  // Derives all but the descriptor anew: after positions or poses changed.
  void UpdateGeometry(int point);
  // Cuts the point's reference patch out of a keyframe that still has its pyramid.
  void SetPatch(int point, const Observation& from);

  // A removed point's id is used again after so many keyframes: longer than the tracker keeps an id. Guessed.
  static constexpr int kPointReuseKeyframes = 20;

 private:
  int ParentFor(const Keyframe& gone) const;
  void UpdateDescriptor(MapPoint& point);
  static void Release(Keyframe& gone);

  CameraModel camera_;
  std::vector<Keyframe> keyframes_;
  std::vector<int> living_;
  std::vector<MapPoint> points_;
  int living_points_ = 0;
  int next_part_ = 0, main_part_ = 0;
  struct Free {
    int point;
    int keyframes;  // that existed when the point died
  };
  std::deque<Free> free_;
};

// A measured rolling shutter (readout_estimator.h).
struct ReadoutEstimate {
  double readout_s = 0;  // from the first row to the last; negative: from the last
  double sigma_s = 0;    // one standard deviation
  int keyframes = 0;     // that it was measured on
};

// Describes what others may know of a map that one thread changes: they hold its lock (MapLock) to read it.
struct SharedMap {
  explicit SharedMap(const Map& owned) : map(owned) {}
  // Serves the thread that changes the map, and others while the mapper is idle: nobody changes the map
  // meanwhile, so that reading without the lock is safe. Thread safety analysis cannot express that.
  const Map& ReadByOwner() const ULF_NO_THREAD_SAFETY_ANALYSIS { return map; }

  mutable Mutex mutex;
  const Map& map ULF_GUARDED_BY(mutex);
  std::atomic<std::thread::id> owner{};  // the mapper's thread
  // The longest time that a thread other than the owner waited for the lock.
  mutable std::chrono::steady_clock::duration longest_wait ULF_GUARDED_BY(mutex){};
  std::atomic<int> loops{0};             // closed so far
  std::atomic<int> joins{0};             // of parts so far; each moves one part into another one's world
  std::atomic<bool> world_given{false};  // the map is in the world in which fiducials are given
  // Counts corrections that move much at once: whoever keeps poses should ask for them again.
  std::atomic<int> revision{0};
  // How often a rolling shutter was measured, and the last result.
  std::atomic<int> readouts_measured{0};
  std::optional<ReadoutEstimate> readout ULF_GUARDED_BY(mutex);
  std::optional<CalibrationCheck> wrong_lens ULF_GUARDED_BY(mutex);  // none: the images do not contradict it
  std::atomic<bool> lens_is_due{false};  // the lens is a guess, and the map may determine a better one
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

// A map and the right to change it, which the mapper alone has. Its thread reads without the lock and takes
// it for every change, so that other threads wait for microseconds only.
struct OwnedMap {
  explicit OwnedMap(Map given) : map(std::move(given)), shared(map) {}
  Map map ULF_GUARDED_BY(shared.mutex);
  SharedMap shared;
};

}  // namespace ulf::tracking
