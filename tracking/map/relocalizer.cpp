#include "tracking/map/relocalizer.h"

#include <algorithm>
#include <functional>
#include <random>
#include <utility>

#include "core/base/at.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/features/matching.h"

namespace ulf::tracking {

namespace {

constexpr MatchOptions kProposalMatching = {.max_distance = 70,
                                            .max_ratio = 0.85};  // a search without prediction. Guessed
constexpr int kProposalMinMatches = 12;  // with the keyframe's points; fewer give no pose. Guessed
constexpr int kProposalMinInliers = 10;  // of the pose, before and after refinement. Guessed
constexpr double kProposalThresholdPx = 5;

}  // namespace

KeyframeIndex::KeyframeIndex(unsigned seed) {
  std::mt19937 random(seed);
  for (auto& table : bits_)
    for (int& bit : table) bit = static_cast<int>(random() % 256);
}

std::uint32_t KeyframeIndex::Key(int table, const Descriptor& descriptor) const {
  std::uint32_t key = 0;
  for (const int bit : bits_[At(table)])
    key = key << 1 | static_cast<std::uint32_t>(descriptor[At(bit / 64)] >> (bit % 64) & 1);
  return key;
}

void KeyframeIndex::Add(const Keyframe& keyframe) {
  Remove(keyframe.id);
  const MutexLock lock(mutex_);
  auto& keys = keys_of_[keyframe.id];
  for (int i = 0; i < keyframe.features->size(); ++i) {
    if (keyframe.point_of_feature[At(i)] < 0) continue;
    auto& of_feature = keys.emplace_back();
    for (int t = 0; t < kTables; ++t) {
      of_feature[At(t)] = Key(t, (*keyframe.features)[i].descriptor);
      tables_[At(t)][of_feature[At(t)]].push_back(keyframe.id);
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
  std::vector<double> votes(At(count), 0), vote(At(count), 0);  // of all features, of this one
  std::vector<int> voted_by(At(count), -1);                     // the last feature that did
  std::vector<int> hit;
  for (int i = 0; i < features.size(); ++i) {
    hit.clear();
    for (int t = 0; t < kTables; ++t) {
      const auto& table = tables_[At(t)];
      const auto bucket = table.find(Key(t, features[i].descriptor));
      if (bucket == table.end() || bucket->second.size() > kTooCommon) continue;
      const double weight = 1.0 / static_cast<double>(bucket->second.size());
      for (const int keyframe : bucket->second) {
        if (std::exchange(voted_by[At(keyframe)], i) != i) {
          hit.push_back(keyframe);
          vote[At(keyframe)] = 0;
        }
        vote[At(keyframe)] = std::max(vote[At(keyframe)], weight);
      }
    }
    for (const int keyframe : hit) votes[At(keyframe)] += vote[At(keyframe)];
  }
  std::vector<Ranked> ranked;
  for (int k = 0; k < count; ++k)
    if (votes[At(k)] > 0) ranked.push_back({k, votes[At(k)]});
  std::ranges::stable_sort(ranked, std::greater{}, &Ranked::votes);
  if (static_cast<int>(ranked.size()) > most) ranked.resize(At(most));
  return ranked;
}

KeyframePoints PointsOf(const Map& map, int id) {
  KeyframePoints points;
  const Keyframe& keyframe = map.keyframe(id);
  if (!keyframe.alive) return points;
  points.features = keyframe.features;
  points.positions.resize(At(keyframe.features->size()));
  for (int i = 0; i < keyframe.features->size(); ++i) {
    const int point = keyframe.point_of_feature[At(i)];
    if (point < 0) continue;
    points.with_points.push_back(i);
    points.positions[At(i)] = map.point(point).position;
  }
  return points;
}

std::optional<Rigid3> ProposePose(const CameraModel& camera, const KeyframePoints& keyframe,
                                  const FeatureSet& features, unsigned seed) {
  if (!keyframe.features) return std::nullopt;
  const auto matches =
      MatchAll(*keyframe.features, keyframe.with_points, features, AllOf(features), kProposalMatching);
  if (static_cast<int>(matches.size()) < kProposalMinMatches) return std::nullopt;
  std::vector<PointObservation> observations;
  for (const FeatureMatch& match : matches) {
    const Feature& feature = features[match.second];
    observations.push_back(
        {keyframe.positions[At(match.first)], feature.img, DetectedSigmaPx(feature.level)});
  }
  const auto pose =
      AbsolutePose(camera, observations,
                   {.threshold_px = kProposalThresholdPx, .min_inliers = kProposalMinInliers, .seed = seed});
  if (!pose) return std::nullopt;
  std::vector<PointObservation> agreeing;
  for (const int i : pose->inliers) agreeing.push_back(observations[At(i)]);
  const auto refined = RefinePose(camera, agreeing, pose->cam_from_world);
  if (!refined || refined->inliers < kProposalMinInliers) return std::nullopt;
  return refined->cam_from_world;
}

}  // namespace ulf::tracking
