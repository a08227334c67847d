#include "tracking/map/relocalizer.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

#include "tracking/estimation/absolute_pose.h"
#include "tracking/features/matching.h"

namespace ulf::tracking {

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
  const MutexLock lock(mutex_);
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
  const MutexLock lock(mutex_);
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
  const MutexLock lock(mutex_);
  for (auto& table : tables_) table.clear();
  keys_of_.clear();
}

std::vector<KeyframeIndex::Ranked> KeyframeIndex::Query(const FeatureSet& features, int most) const {
  const MutexLock lock(mutex_);
  int count = 0;
  for (const auto& [keyframe, keys] : keys_of_) count = std::max(count, keyframe + 1);
  std::vector<double> votes(static_cast<std::size_t>(count), 0);
  std::vector<int> voted_by(static_cast<std::size_t>(count), -1);  // the last feature that did
  std::vector<int> hit;
  for (int i = 0; i < features.size(); ++i) {
    hit.clear();
    double weight = 0;
    for (int t = 0; t < kTables; ++t) {
      const auto& table = tables_[static_cast<std::size_t>(t)];
      const auto bucket = table.find(Key(t, features[i].descriptor));
      if (bucket == table.end() || bucket->second.size() > kTooCommon) continue;
      for (const int keyframe : bucket->second)
        if (std::exchange(voted_by[static_cast<std::size_t>(keyframe)], i) != i) hit.push_back(keyframe);
      weight = std::max(weight, 1.0 / static_cast<double>(bucket->second.size()));
    }
    for (const int keyframe : hit) votes[static_cast<std::size_t>(keyframe)] += weight;
  }
  std::vector<Ranked> ranked;
  for (int k = 0; k < count; ++k)
    if (votes[static_cast<std::size_t>(k)] > 0) ranked.push_back({k, votes[static_cast<std::size_t>(k)]});
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Ranked& a, const Ranked& b) { return a.votes > b.votes; });
  if (static_cast<int>(ranked.size()) > most) ranked.resize(static_cast<std::size_t>(most));
  return ranked;
}

KeyframePoints PointsOf(const Map& map, int id) {
  KeyframePoints points;
  points.keyframe = id;
  const Keyframe& keyframe = map.keyframe(id);
  if (!keyframe.alive) return points;
  points.features = keyframe.features;
  points.positions.resize(static_cast<std::size_t>(keyframe.features->size()));
  for (int i = 0; i < keyframe.features->size(); ++i) {
    const int point = keyframe.point_of_feature[static_cast<std::size_t>(i)];
    if (point < 0) continue;
    points.with_points.push_back(i);
    points.positions[static_cast<std::size_t>(i)] = map.point(point).position;
  }
  return points;
}

std::optional<PoseProposal> ProposePose(const CameraModel& camera, const KeyframePoints& keyframe,
                                        const FeatureSet& features, unsigned seed) {
  constexpr int kMinMatches = 12;
  if (!keyframe.features) return std::nullopt;
  std::vector<int> all(static_cast<std::size_t>(features.size()));
  std::iota(all.begin(), all.end(), 0);
  const auto matches = MatchAll(*keyframe.features, keyframe.with_points, features, all,
                                {.max_distance = 70, .max_ratio = 0.85, .same_rotation = true});
  if (static_cast<int>(matches.size()) < kMinMatches) return std::nullopt;
  std::vector<PointObservation> observations;
  for (const FeatureMatch& match : matches) {
    const Feature& feature = features[match.second];
    observations.push_back({keyframe.positions[static_cast<std::size_t>(match.first)], feature.img,
                            DetectedSigmaPx(feature.level)});
  }
  const auto pose = AbsolutePose(camera, observations, {.threshold_px = 5, .min_inliers = 10, .seed = seed});
  if (!pose) return std::nullopt;
  std::vector<PointObservation> agreeing;
  for (const int i : pose->inliers) agreeing.push_back(observations[static_cast<std::size_t>(i)]);
  const auto refined = RefinePose(camera, agreeing, pose->cam_from_world);
  if (!refined || refined->inliers < 10) return std::nullopt;
  return PoseProposal{refined->cam_from_world, refined->inliers, keyframe.keyframe};
}

}  // namespace ulf::tracking
