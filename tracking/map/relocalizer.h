// Finds keyframes that look like a frame, and a pose from descriptors alone: for a lost camera and for loops.
//
// An index of descriptors ranks the keyframes. It files each descriptor under several keys of randomly drawn
// bits (locality sensitive hashing, Indyk and Motwani 1998); a feature votes for each keyframe by the rarest
// key that it shares with it, so that many points alone bring no votes. The frame is then matched with the
// best ranked keyframes, and P3P in the seeded sampler proposes a pose. The caller verifies the proposal
// against the whole map.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

class KeyframeIndex {
 public:
  explicit KeyframeIndex(unsigned seed);
  // Files the descriptors of the keyframe's features that have points; replaces those filed before.
  void Add(const Keyframe& keyframe);
  void Remove(int keyframe);
  void Clear();
  struct Ranked {
    int keyframe = -1;
    double votes = 0;
  };
  // Returns keyframes by falling similarity.
  std::vector<Ranked> Query(const FeatureSet& features, int most) const;

 private:
  // More tables find more of the disturbed descriptors, more bits confuse fewer; both cost time. Measured:
  // BM_RelocalizeAmong1000Keyframes.
  static constexpr int kTables = 12;
  static constexpr int kBits = 16;
  // A key with more entries does not tell keyframes apart. Guessed.
  static constexpr std::size_t kTooCommon = 200;
  std::uint32_t Key(int table, const Descriptor& descriptor) const;
  mutable Mutex mutex_;
  std::array<std::array<int, kBits>, kTables> bits_{};
  // By table: keyframes by key.
  std::array<std::unordered_map<std::uint32_t, std::vector<int>>, kTables> tables_ ULF_GUARDED_BY(mutex_);
  std::unordered_map<int, std::vector<std::array<std::uint32_t, kTables>>> keys_of_ ULF_GUARDED_BY(mutex_);
};

// Describes what a keyframe shows of the map, copied so that matching needs no lock.
struct KeyframePoints {
  std::shared_ptr<const FeatureSet> features;
  std::vector<int> with_points;            // features
  std::vector<Eigen::Vector3d> positions;  // by feature; only of those with points
};
// It is empty for a removed keyframe. Reads the map: the caller holds its lock.
KeyframePoints PointsOf(const Map& map, int keyframe);

// Returns the pose that matches with one keyframe's points suggest.
std::optional<Rigid3> ProposePose(const CameraModel& camera, const KeyframePoints& keyframe,
                                  const FeatureSet& features, unsigned seed);

}  // namespace ulf::tracking
