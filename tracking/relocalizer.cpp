#include "tracking/relocalizer.h"

#include <algorithm>
#include <map>
#include <random>

#include "tracking/absolute_pose.h"
#include "tracking/matching.h"

namespace ulf {

KeyframeIndex::KeyframeIndex(unsigned seed) {
  std::mt19937 random(seed);
  for (auto& table : bits_)
    for (int& bit : table) bit = static_cast<int>(random() % 256);
}

std::uint32_t KeyframeIndex::Key(int table, const Descriptor& descriptor) const {
  std::uint32_t key = 0;
  for (const int bit : bits_[static_cast<std::size_t>(table)])
    key = key << 1 |
          static_cast<std::uint32_t>(descriptor[static_cast<std::size_t>(bit / 64)] >> (bit % 64) & 1);
  return key;
}

void KeyframeIndex::Add(const Keyframe& keyframe) {
  Remove(keyframe.id);
  const std::lock_guard lock(mutex_);
  auto& keys = keys_of_[keyframe.id];
  for (int i = 0; i < keyframe.features->size(); ++i) {
    if (keyframe.point_of_feature[static_cast<std::size_t>(i)] < 0) continue;
    auto& of_feature = keys.emplace_back();
    for (int t = 0; t < kTables; ++t) {
      of_feature[static_cast<std::size_t>(t)] = Key(t, (*keyframe.features)[i].descriptor);
      tables_[static_cast<std::size_t>(t)][of_feature[static_cast<std::size_t>(t)]].push_back(keyframe.id);
    }
  }
}

void KeyframeIndex::Remove(int keyframe) {
  const std::lock_guard lock(mutex_);
  const auto found = keys_of_.find(keyframe);
  if (found == keys_of_.end()) return;
  for (const auto& of_feature : found->second)
    for (std::size_t t = 0; t < kTables; ++t) {
      const auto bucket = tables_[t].find(of_feature[t]);
      if (bucket == tables_[t].end()) continue;
      std::erase(bucket->second, keyframe);
      if (bucket->second.empty()) tables_[t].erase(bucket);
    }
  keys_of_.erase(found);
}

void KeyframeIndex::Clear() {
  const std::lock_guard lock(mutex_);
  for (auto& table : tables_) table.clear();
  keys_of_.clear();
}

std::vector<int> KeyframeIndex::Query(const FeatureSet& features, int most) const {
  const std::lock_guard lock(mutex_);
  std::map<int, double> votes;
  std::vector<int> hit;
  for (const Feature& feature : features.all()) {
    hit.clear();
    double weight = 0;
    for (int t = 0; t < kTables; ++t) {
      const auto& table = tables_[static_cast<std::size_t>(t)];
      const auto bucket = table.find(Key(t, feature.descriptor));
      if (bucket == table.end()) continue;
      hit.insert(hit.end(), bucket->second.begin(), bucket->second.end());
      weight = std::max(weight, 1.0 / static_cast<double>(bucket->second.size()));
    }
    std::sort(hit.begin(), hit.end());
    hit.erase(std::unique(hit.begin(), hit.end()), hit.end());
    for (const int keyframe : hit) votes[keyframe] += weight;
  }
  std::vector<std::pair<double, int>> ranked;
  for (const auto& [keyframe, vote] : votes) ranked.emplace_back(-vote, keyframe);
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> best;
  for (const auto& [vote, keyframe] : ranked)
    if (static_cast<int>(best.size()) < most) best.push_back(keyframe);
  return best;
}

std::optional<PoseProposal> ProposePose(const CameraModel& camera, const Map& map, int keyframe_id,
                                        const FeatureSet& features, unsigned seed) {
  constexpr int kMinMatches = 12;
  const Keyframe& keyframe = map.keyframe(keyframe_id);
  if (!keyframe.alive) return std::nullopt;
  std::vector<int> with_points, all(static_cast<std::size_t>(features.size()));
  for (int i = 0; i < keyframe.features->size(); ++i)
    if (keyframe.point_of_feature[static_cast<std::size_t>(i)] >= 0) with_points.push_back(i);
  for (int i = 0; i < features.size(); ++i) all[static_cast<std::size_t>(i)] = i;
  const auto matches = MatchAll(*keyframe.features, with_points, features, all,
                                {.max_distance = 70, .max_ratio = 0.85, .same_rotation = true});
  if (static_cast<int>(matches.size()) < kMinMatches) return std::nullopt;
  std::vector<PointObservation> observations;
  for (const FeatureMatch& match : matches) {
    const int point = keyframe.point_of_feature[static_cast<std::size_t>(match.first)];
    const Feature& feature = features[match.second];
    observations.push_back({map.point(point).position, feature.img, DetectedSigmaPx(feature.level)});
  }
  const auto pose = AbsolutePose(camera, observations, {.threshold_px = 5, .min_inliers = 10, .seed = seed});
  if (!pose) return std::nullopt;
  std::vector<PointObservation> agreeing;
  for (const int i : pose->inliers) agreeing.push_back(observations[static_cast<std::size_t>(i)]);
  const auto refined = RefinePose(camera, agreeing, pose->cam_from_world);
  if (!refined || refined->inliers < 10) return std::nullopt;
  return PoseProposal{refined->cam_from_world, refined->inliers, keyframe_id};
}

}  // namespace ulf
