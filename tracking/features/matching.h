// Matches features by their descriptors: in a window around where one is expected, or each against all.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "tracking/features/features.h"

namespace ulf::tracking {

// Hamming distance of 256 bits up to which two descriptors are taken for the same thing: true matches lie
// around 30, chance around 128. Guessed.
inline constexpr int kSureDistance = 50;

struct FeatureMatch {
  int first = -1;  // indices of features
  int second = -1;
  int distance = 0;  // of the descriptors, bits
};

struct MatchOptions {
  int max_distance = kSureDistance;  // bits; above it a pair is no match
  double max_ratio = 0.9;            // best distance / second best; above it the match is ambiguous. Guessed
};

// The candidate with the nearest descriptor of those offered, and the second best distance (ratio test).
struct NearestDescriptor {
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

// Matches every feature of `first` against those of `second` within `radius_px` of `expected` (by feature of
// `first`), on levels within one of its own. Each feature is used at most once. Applies KeepSameRotation().
std::vector<FeatureMatch> MatchInWindow(const FeatureSet& first, const FeatureSet& second,
                                        std::span<const Eigen::Vector2d> expected, double radius_px,
                                        const MatchOptions& options = {});

// Returns the indices of all features of a set.
std::vector<int> AllOf(const FeatureSet& features);

// Matches the chosen features (indices) of two sets by their nearest descriptors. Each feature is used at
// most once. Applies KeepSameRotation().
std::vector<FeatureMatch> MatchAll(const FeatureSet& first, std::span<const int> chosen_in_first,
                                   const FeatureSet& second, std::span<const int> chosen_in_second,
                                   const MatchOptions& options = {});

// A map point that the image should show, and the window in which it is searched.
struct Expected {
  Eigen::Vector2d img;
  double radius_px = 0;
  int lowest_level = 0;
  int highest_level = kPyramidLevels - 1;
  const Descriptor* descriptor = nullptr;  // never null when matched
};

// Returns each point's feature, or -1. A feature that two points match goes to the nearer descriptor.
std::vector<int> MatchExpected(std::span<const Expected> expected, const FeatureSet& features,
                               const MatchOptions& options = {});

// Two features closer than this (level pixels) may be one corner on several levels; farther apart and with
// the same descriptor they are two things that look alike. Guessed.
inline constexpr double kRepetitionApartPx = 10;

// Returns whether another place in the same image has a descriptor within `distance` bits of this feature's,
// as on a wall of tiles. Without a prediction, matching confuses the two.
bool IsRepetitive(const FeatureSet& features, int feature, int distance);

// Drops matches whose patches turned from the first image to the second by another angle than most did.
void KeepSameRotation(const FeatureSet& first, const FeatureSet& second, std::vector<FeatureMatch>& matches);

}  // namespace ulf::tracking
