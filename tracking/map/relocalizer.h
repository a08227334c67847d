// Finds keyframes that look like a frame, and proposes a pose by descriptors: for lost cameras and loops.
//
// An index of descriptors ranks the keyframes. It files each descriptor under several keys of randomly drawn
// bits (locality sensitive hashing, Indyk and Motwani 1998); a feature votes for each keyframe by the rarest
// key that it shares with it, so that many points alone bring no votes. The caller matches the frame with the
// best ranked keyframes (ProposePose()), and verifies the proposed pose against the whole map.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// The mapper owns and fills the index; any thread may query it.
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
  // Returns at most `most` keyframes with votes, by falling votes.
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

// What a keyframe shows of the map, copied so that matching needs no lock.
struct KeyframePoints {
  std::shared_ptr<const FeatureSet> features;
  std::vector<int> with_points;            // indices of features that have points
  std::vector<Eigen::Vector3d> positions;  // by feature, in the world; set for those with points
};
// Returns an empty value for a removed keyframe. The caller holds the map's lock.
KeyframePoints PointsOf(const Map& map, int keyframe);

// Returns the pose cam_from_world that matches with one keyframe's points suggest; none if too few agree.
std::optional<Rigid3> ProposePose(const CameraModel& camera, const KeyframePoints& keyframe,
                                  const FeatureSet& features, unsigned seed);

}  // namespace ulf::tracking
