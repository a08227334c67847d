// Finding a lost camera: which keyframes look like this frame, and a pose from descriptors alone.
//
// Keyframes are ranked by an index of descriptors: each is filed under several keys of bits drawn at random
// (locality sensitive hashing, Indyk and Motwani 1998); a query votes for the keyframes that share a key, a
// rare key counting more. The best ranked are matched for good and a pose is sought with P3P inside our
// seeded sampler, then refined. The proposal is not yet an answer: the caller verifies it against the whole
// map.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "tracking/features/features.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

class KeyframeIndex {
 public:
  explicit KeyframeIndex(unsigned seed);
  // The descriptors of the keyframe's features that carry points. Adding again replaces.
  void Add(const Keyframe& keyframe);
  void Remove(int keyframe);
  void Clear();
  struct Ranked {
    int keyframe = -1;
    double votes = 0;
  };
  // Keyframes by falling similarity.
  std::vector<Ranked> Query(const FeatureSet& features, int most) const;

 private:
  static constexpr int kTables = 12;
  static constexpr int kBits = 16;
  // A key under which more is filed says nothing about which keyframe it is.
  static constexpr std::size_t kTooCommon = 200;
  std::uint32_t Key(int table, const Descriptor& descriptor) const;
  mutable Mutex mutex_;
  std::array<std::array<int, kBits>, kTables> bits_{};
  // Key -> keyframes.
  std::array<std::unordered_map<std::uint32_t, std::vector<int>>, kTables> tables_ ULF_GUARDED_BY(mutex_);
  std::unordered_map<int, std::vector<std::array<std::uint32_t, kTables>>> keys_of_ ULF_GUARDED_BY(mutex_);
};

struct PoseProposal {
  Rigid3 cam_from_world;
  int inliers = 0;
  int keyframe = -1;
};

// What a keyframe shows of the map, copied so that matching needs no lock.
struct KeyframePoints {
  int keyframe = -1;
  std::shared_ptr<const FeatureSet> features;
  std::vector<int> with_points;            // features
  std::vector<Eigen::Vector3d> positions;  // by feature; of those with points
};
// Of a removed keyframe: nothing. `map` is read: hold its lock.
KeyframePoints PointsOf(const Map& map, int keyframe);

// The pose that matches with one keyframe's points suggest.
std::optional<PoseProposal> ProposePose(const CameraModel& camera, const KeyframePoints& keyframe,
                                        const FeatureSet& features, unsigned seed);

}  // namespace ulf::tracking
