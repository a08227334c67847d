#include "tracking/features/matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/at.h"

namespace ulf::tracking {
namespace {

// Keeps one match for each feature of the second set: the nearest.
void KeepNearestOwner(int second_size, std::vector<FeatureMatch>& matches) {
  std::vector<int> owner(At(second_size), -1);
  for (int m = 0; m < static_cast<int>(matches.size()); ++m) {
    int& current = owner[At(matches[At(m)].second)];
    if (current < 0 || matches[At(m)].distance < matches[At(current)].distance) current = m;
  }
  std::vector<FeatureMatch> kept;
  for (int m = 0; m < static_cast<int>(matches.size()); ++m)
    if (owner[At(matches[At(m)].second)] == m) kept.push_back(matches[At(m)]);
  matches = std::move(kept);
}

// A vector, not a view: Clang 14 cannot compile this library's views.
std::vector<int> AllBelow(int count) {
  std::vector<int> indices(At(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

// `offer(i, nearest)` offers `nearest` the features of the second set that i may match.
template <typename Offer>
std::vector<FeatureMatch> NearestMatches(std::span<const int> first, int second_size,
                                         const MatchOptions& options, const Offer& offer) {
  std::vector<FeatureMatch> matches;
  for (const int i : first) {
    NearestDescriptor nearest;
    offer(i, nearest);
    if (nearest.Passes(options)) matches.push_back({i, nearest.index, nearest.distance});
  }
  KeepNearestOwner(second_size, matches);
  return matches;
}

}  // namespace

std::vector<int> AllOf(const FeatureSet& features) { return AllBelow(features.size()); }

std::vector<FeatureMatch> MatchInWindow(const FeatureSet& first, const FeatureSet& second,
                                        std::span<const Eigen::Vector2d> expected, double radius_px,
                                        const MatchOptions& options) {
  const auto offer = [&](int i, NearestDescriptor& nearest) {
    const Feature& feature = first[i];
    second.ForEachNear(expected[At(i)], radius_px, feature.level - 1, feature.level + 1,
                       [&](int j) { nearest.Offer(j, Distance(feature.descriptor, second[j].descriptor)); });
  };
  std::vector<FeatureMatch> matches = NearestMatches(AllOf(first), second.size(), options, offer);
  KeepSameRotation(first, second, matches);
  return matches;
}

std::vector<FeatureMatch> MatchAll(const FeatureSet& first, std::span<const int> chosen_in_first,
                                   const FeatureSet& second, std::span<const int> chosen_in_second,
                                   const MatchOptions& options) {
  const auto offer = [&](int i, NearestDescriptor& nearest) {
    for (const int j : chosen_in_second)
      nearest.Offer(j, Distance(first[i].descriptor, second[j].descriptor));
  };
  std::vector<FeatureMatch> matches = NearestMatches(chosen_in_first, second.size(), options, offer);
  KeepSameRotation(first, second, matches);
  return matches;
}

std::vector<int> MatchExpected(std::span<const Expected> expected, const FeatureSet& features,
                               const MatchOptions& options) {
  const auto offer = [&](int i, NearestDescriptor& nearest) {
    const Expected& wanted = expected[At(i)];
    features.ForEachNear(wanted.img, wanted.radius_px, wanted.lowest_level, wanted.highest_level, [&](int j) {
      nearest.Offer(j, Distance(*wanted.descriptor, features[j].descriptor));
    });
  };
  const std::vector<FeatureMatch> matches =
      NearestMatches(AllBelow(static_cast<int>(expected.size())), features.size(), options, offer);
  std::vector<int> feature_of(expected.size(), -1);
  for (const FeatureMatch& match : matches) feature_of[At(match.first)] = match.second;
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

bool IsRepetitive(const FeatureSet& features, int feature, int distance) {
  const Feature& one = features[feature];
  const double apart_px = kRepetitionApartPx * LevelScale(one.level);
  return std::any_of(features.all().begin(), features.all().end(), [&](const Feature& other) {
    return Distance(one.descriptor, other.descriptor) <= distance &&
           (one.img - other.img).squaredNorm() > apart_px * apart_px;
  });
}

}  // namespace ulf::tracking
