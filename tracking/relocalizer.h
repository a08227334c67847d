// Finding a lost camera: which keyframes look like this frame, and a pose from descriptors alone.
//
// Keyframes are ranked by an index of descriptors: each is filed under several keys of bits drawn at random
// (locality sensitive hashing, Indyk and Motwani 1998); a query votes for the keyframes that share a key, a
// rare key counting more. The best ranked are matched for good and a pose is sought with P3P inside our
// seeded sampler, then refined. The proposal is not yet an answer: the caller verifies it against the whole
// map.
#pragma once

#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "acquisition/camera_model.h"
#include "tracking/features.h"
#include "tracking/map.h"

namespace ulf {

class KeyframeIndex {
 public:
  explicit KeyframeIndex(unsigned seed);
  // The descriptors of the keyframe's features that carry points. Adding again replaces.
  void Add(const Keyframe& keyframe);
  void Remove(int keyframe);
  void Clear();
  // Keyframes by falling similarity.
  std::vector<int> Query(const FeatureSet& features, int most) const;

 private:
  static constexpr int kTables = 12;
  static constexpr int kBits = 16;
  std::uint32_t Key(int table, const Descriptor& descriptor) const;
  mutable std::mutex mutex_;
  std::array<std::array<int, kBits>, kTables> bits_{};
  std::array<std::unordered_map<std::uint32_t, std::vector<int>>, kTables> tables_;  // key -> keyframes
  std::unordered_map<int, std::vector<std::array<std::uint32_t, kTables>>> keys_of_;
};

struct PoseProposal {
  Rigid3 cam_from_world;
  int inliers = 0;
  int keyframe = -1;
};

// The pose that matches with one keyframe's points suggest. `map` is read: hold its lock.
std::optional<PoseProposal> ProposePose(const CameraModel& camera, const Map& map, int keyframe,
                                        const FeatureSet& features, unsigned seed);

}  // namespace ulf
