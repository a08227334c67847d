// Matching descriptors: in a window around where a point is expected, or each against all.
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "tracking/features/features.h"

namespace ulf::tracking {

// Hamming distances of 256 bits. True matches lie around 30, chance around 128.
inline constexpr int kSureDistance = 50;
inline constexpr int kMaxDistance = 90;

struct FeatureMatch {
  int first = -1;
  int second = -1;
  int distance = 0;
};

struct MatchOptions {
  int max_distance = kSureDistance;
  double max_ratio = 0.9;     // best distance / second best
  bool same_rotation = true;  // keep matches whose patches turned alike
};

// Every feature of `first` on `levels_from` against those of `second` around `expected` (by feature of
// first), on levels within one of its own. Each feature is used at most once.
std::vector<FeatureMatch> MatchInWindow(const FeatureSet& first, const FeatureSet& second,
                                        std::span<const Eigen::Vector2d> expected, double radius_px,
                                        const MatchOptions& options = {});

// Mutual best among the chosen features of two sets.
std::vector<FeatureMatch> MatchAll(const FeatureSet& first, std::span<const int> chosen_in_first,
                                   const FeatureSet& second, std::span<const int> chosen_in_second,
                                   const MatchOptions& options = {});

// A map point where the image should show it.
struct Expected {
  Eigen::Vector2d img;
  double radius_px = 0;
  int lowest_level = 0;
  int highest_level = kPyramidLevels - 1;
  const Descriptor* descriptor = nullptr;
};

// The feature of each expectation, or -1. A feature wanted twice goes to the nearer descriptor.
std::vector<int> MatchExpected(std::span<const Expected> expected, const FeatureSet& features,
                               const MatchOptions& options = {});

// Whether another place in the same picture looks like this feature, to within `distance`: a tile among
// tiles, which a search that is not led by a prediction takes for its neighbour.
bool HasTwin(const FeatureSet& features, int feature, int distance);

// Drops matches whose patches turned otherwise than most did.
void KeepSameRotation(const FeatureSet& first, const FeatureSet& second, std::vector<FeatureMatch>& matches);

}  // namespace ulf::tracking
