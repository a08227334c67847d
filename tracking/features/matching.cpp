#include "tracking/features/matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ulf::tracking {
namespace {

// The nearest descriptor so far, and the runner-up that the ratio test needs.
struct Nearest {
  int index = -1;
  int distance = std::numeric_limits<int>::max();
  int second = std::numeric_limits<int>::max();

  void Offer(int candidate, int candidate_distance) {
    if (candidate_distance < distance) {
      second = distance;
      distance = candidate_distance;
      index = candidate;
    } else if (candidate_distance < second) {
      second = candidate_distance;
    }
  }
  bool Passes(const MatchOptions& options) const {
    return index >= 0 && distance <= options.max_distance &&
           (second == std::numeric_limits<int>::max() || distance <= options.max_ratio * second);
  }
};

// Gives each feature of the second set to the nearest of those that chose it.
void KeepNearestOwner(int second_size, std::vector<FeatureMatch>& matches) {
  std::vector<int> owner(static_cast<std::size_t>(second_size), -1);
  for (int m = 0; m < static_cast<int>(matches.size()); ++m) {
    int& current = owner[static_cast<std::size_t>(matches[static_cast<std::size_t>(m)].second)];
    if (current < 0 ||
        matches[static_cast<std::size_t>(m)].distance < matches[static_cast<std::size_t>(current)].distance)
      current = m;
  }
  std::vector<FeatureMatch> kept;
  for (int m = 0; m < static_cast<int>(matches.size()); ++m)
    if (owner[static_cast<std::size_t>(matches[static_cast<std::size_t>(m)].second)] == m)
      kept.push_back(matches[static_cast<std::size_t>(m)]);
  matches = std::move(kept);
}

}  // namespace

std::vector<FeatureMatch> MatchInWindow(const FeatureSet& first, const FeatureSet& second,
                                        std::span<const Eigen::Vector2d> expected, double radius_px,
                                        const MatchOptions& options) {
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < first.size(); ++i) {
    const Feature& feature = first[i];
    Nearest nearest;
    second.ForEachNear(expected[static_cast<std::size_t>(i)], radius_px, feature.level - 1, feature.level + 1,
                       [&](int j) { nearest.Offer(j, Distance(feature.descriptor, second[j].descriptor)); });
    if (nearest.Passes(options)) matches.push_back({i, nearest.index, nearest.distance});
  }
  KeepNearestOwner(second.size(), matches);
  if (options.same_rotation) KeepSameRotation(first, second, matches);
  return matches;
}

std::vector<FeatureMatch> MatchAll(const FeatureSet& first, std::span<const int> chosen_in_first,
                                   const FeatureSet& second, std::span<const int> chosen_in_second,
                                   const MatchOptions& options) {
  std::vector<FeatureMatch> matches;
  for (const int i : chosen_in_first) {
    Nearest nearest;
    for (const int j : chosen_in_second)
      nearest.Offer(j, Distance(first[i].descriptor, second[j].descriptor));
    if (nearest.Passes(options)) matches.push_back({i, nearest.index, nearest.distance});
  }
  KeepNearestOwner(second.size(), matches);
  if (options.same_rotation) KeepSameRotation(first, second, matches);
  return matches;
}

std::vector<int> MatchExpected(std::span<const Expected> expected, const FeatureSet& features,
                               const MatchOptions& options) {
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < static_cast<int>(expected.size()); ++i) {
    const Expected& wanted = expected[static_cast<std::size_t>(i)];
    Nearest nearest;
    features.ForEachNear(wanted.img, wanted.radius_px, wanted.lowest_level, wanted.highest_level, [&](int j) {
      nearest.Offer(j, Distance(*wanted.descriptor, features[j].descriptor));
    });
    if (nearest.Passes(options)) matches.push_back({i, nearest.index, nearest.distance});
  }
  KeepNearestOwner(features.size(), matches);
  std::vector<int> feature_of(expected.size(), -1);
  for (const FeatureMatch& match : matches) feature_of[static_cast<std::size_t>(match.first)] = match.second;
  return feature_of;
}

void KeepSameRotation(const FeatureSet& first, const FeatureSet& second, std::vector<FeatureMatch>& matches) {
  constexpr int kBins = 30;
  std::array<int, kBins> histogram{};
  const auto bin_of = [&](const FeatureMatch& match) {
    double turn = second[match.second].angle_rad - first[match.first].angle_rad;
    turn -= 2 * M_PI * std::floor(turn / (2 * M_PI));
    return static_cast<std::size_t>(turn / (2 * M_PI) * kBins) % kBins;
  };
  for (const FeatureMatch& match : matches) ++histogram[bin_of(match)];
  // The best bin with its neighbours: a window of three.
  std::size_t best = 0;
  int most = -1;
  for (std::size_t b = 0; b < kBins; ++b) {
    const int count = histogram[(b + kBins - 1) % kBins] + histogram[b] + histogram[(b + 1) % kBins];
    if (count > most) {
      most = count;
      best = b;
    }
  }
  std::erase_if(matches, [&](const FeatureMatch& match) {
    const std::size_t apart = (bin_of(match) + kBins - best) % kBins;
    return apart > 1 && apart < kBins - 1;
  });
}

bool HasTwin(const FeatureSet& features, int feature, int distance) {
  const Feature& one = features[feature];
  // The same corner on other levels is no twin.
  const double apart_px = 10 * LevelScale(one.level);
  return std::any_of(features.all().begin(), features.all().end(), [&](const Feature& other) {
    return Distance(one.descriptor, other.descriptor) <= distance &&
           (one.img - other.img).squaredNorm() > apart_px * apart_px;
  });
}

}  // namespace ulf::tracking
