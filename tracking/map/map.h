// Holds the tracker's map: keyframes and the points that they see, as values with ids.
//
// Keyframes are numbered as they come. A removed keyframe keeps its pose relative to a living one, so that
// poses anchored to it stay valid; the rest of it is freed. The id of a removed point is used again after
// kPointReuseKeyframes keyframes, so that the map does not grow with time; until then a merged point names
// the point into which it was merged. World units are arbitrary until the map is moved into a given world;
// image points are level 0 pixels with centres at integer + 0.5. Map is not synchronised; SharedMap and
// OwnedMap say who may read and who may change it.
//
// A camera that stays lost begins another part of the map: keyframes and points with a world of their own,
// until the loop closer finds how the parts lie to each other and joins them. Users see the main part's
// world.
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
  int feature = -1;                               // index into Keyframe::features
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // where the point's patch was aligned, else the feature's
  double sigma_px = 1;
};

struct MapPoint {
  int id = -1;
  bool alive = true;
  int part = 0;
  int merged_into = -1;  // id of the point that this removed one has become
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<Observation> observations;
  std::vector<ViewObservation> views;  // recorded views that show it, one each; most are no keyframes
  int first_keyframe = -1;             // the newest keyframe when the point was made
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
  // Numbers of frames that should have shown it, and of those in which it was found.
  int expected = 0;
  int found = 0;
  // Map::Update() derives the following from the observations.
  Descriptor descriptor{};
  Eigen::Vector3d mean_direction = Eigen::Vector3d::Zero();  // unit, from the viewing cameras to the point
  double parallax = 0;               // about the angle between its outermost viewing directions, radians
  double reference_distance = 0;     // from which level 0 shows it at the size at which it was seen
  double nearest = 0, farthest = 0;  // distances between which the pyramid can show it
  std::shared_ptr<const ReferencePatch> patch;  // its picture (patch_alignment.h); null: there is none
  int patch_keyframe = -1;                      // from which the patch was cut
  PatchAxes patch_axes = PatchAxes::Zero();
};

struct Keyframe {
  int id = -1;
  bool alive = true;
  int part = 0;
  double time_s = 0;
  Rigid3 cam_from_world;
  // The factor by which loops, joins and MoveWorld() have scaled the lengths around it since it was made.
  double unit = 1;
  // The pose of a removed keyframe relative to a living one.
  int parent = -1;
  Rigid3 cam_from_parent;
  std::vector<int> children;  // removed keyframes whose parent this living one is
  std::shared_ptr<const FeatureSet> features;
  std::shared_ptr<const Pyramid> pyramid;  // of recent keyframes only
  // The rolling shutter's shift that was removed from features and observations; null: none was.
  std::shared_ptr<const RowShift> rows;
  std::optional<Twist> expected_twist;  // prior of the velocity of `rows`, from the tracker
  std::optional<Twist> velocity;        // from the frames before and after
  cv::Mat color;                        // 8 bits, B G R or grey; of recent keyframes only
  bool pinned = false;                  // its pose is given (a seed): never adjusted, never removed
  // Corners of a given world that this frame saw, where the sensor saw them (fiducial_observation.h).
  std::vector<PointObservation> corners = {};
  std::vector<int> point_of_feature;  // ids of points; -1: none
  int points = 0;                     // number of features with a point
  int points_at_birth = 0;            // the same when the keyframe was made
};

class Map {
 public:
  explicit Map(const CameraModel& camera) : camera_(camera) {}

  // Replaces the lens by another of the same image size: image points stay, the features' rays change.
  void SetCamera(const CameraModel& camera);
  int AddKeyframe(Keyframe keyframe);                           // returns its id; it has no observations yet
  int AddPoint(const Eigen::Vector3d& position, int part = 0);  // returns its id
  // Returns false if the feature has a point, the keyframe observes the point already, or one is removed.
  bool AddObservation(int point, const Observation& observation);
  // Adds a recorded view that shows the point, unless the point has it already.
  void AddView(int point, const ViewObservation& seen);
  void RemoveObservation(int point, int keyframe);  // also removes the point if fewer than two are left
  void RemovePoint(int point);
  // Removes `gone`, adds its observations to `kept` as far as that can take them, and returns those.
  std::span<Observation> Merge(int gone, int kept);
  void RemoveKeyframe(int keyframe);  // keeps the last living one of a part

  int BeginPart() { return next_part_++; }  // returns its number; numbers are not used again
  // Makes keyframes and points of `gone` part of `kept`. The caller has moved them into its world.
  void JoinPart(int gone, int kept);
  // Removes all points and keyframes of a part; PoseOf() keeps their last poses.
  void RemovePart(int part);
  void SetMainPart(int part) { main_part_ = part; }
  int main_part() const { return main_part_; }
  std::vector<int> Parts() const;  // numbers of parts with living keyframes, ascending

  const Keyframe& keyframe(int id) const { return keyframes_[At(id)]; }
  Keyframe& keyframe(int id) { return keyframes_[At(id)]; }
  const MapPoint& point(int id) const { return points_[At(id)]; }
  MapPoint& point(int id) { return points_[At(id)]; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<MapPoint>& points() const { return points_; }
  const std::vector<int>& living() const { return living_; }  // ids of keyframes, ascending
  std::vector<int> LivingOf(int part) const;
  int FirstKeyframe(int part) const;  // the first living one; -1: none
  int LivingKeyframes() const { return static_cast<int>(living_.size()); }
  int LivingPoints() const { return living_points_; }
  // Returns `id`, or the living point into which it was merged; -1 if there is none.
  int Resolve(int id) const;

  // Return the present poses (cam_from_world) of keyframes, removed ones included, and of anchors.
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

  // Call Update() after observations changed, UpdateGeometry() after positions or poses alone.
  void Update(int point);
  void UpdateGeometry(int point);
  // Cuts the point's reference patch out of the keyframe of `from`, if that still has its pyramid.
  void SetPatch(int point, const Observation& from);

  // A removed point's id is used again after so many keyframes: longer than the tracker keeps it. Guessed.
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
  double readout_s = 0;  // time from the first row to the last; negative: the last row is read first
  double sigma_s = 0;    // one standard deviation
  int keyframes = 0;     // number of keyframes that tell it
};

// What threads other than the mapper's may know of its map. They hold the lock (MapLock) to read the map.
struct SharedMap {
  explicit SharedMap(const Map& owned) : map(owned) {}
  // Returns the map without the lock, for the thread that changes it, and for others while the mapper is
  // idle. Nobody changes it meanwhile, which thread safety analysis cannot express.
  const Map& ReadByOwner() const ULF_NO_THREAD_SAFETY_ANALYSIS { return map; }

  mutable Mutex mutex;
  const Map& map ULF_GUARDED_BY(mutex);
  std::atomic<std::thread::id> owner{};  // the mapper's thread
  // The longest time that a thread other than the owner waited for the lock.
  mutable std::chrono::steady_clock::duration longest_wait ULF_GUARDED_BY(mutex){};
  std::atomic<int> loops{0};             // number of loops closed
  std::atomic<int> joins{0};             // number of parts that moved into another one's world
  std::atomic<bool> world_given{false};  // the map is in the world in which fiducials are given
  // Number of corrections that moved much at once: whoever keeps poses should ask for them again.
  std::atomic<int> revision{0};
  // How often a rolling shutter was measured, and the last result; none: the map did not determine it.
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
