#include "tracking/map/pose_error.h"

#include <algorithm>
#include <cmath>

namespace ulf::tracking {
namespace {

// Guessed.
// The newest, whose moves are measured: fewer jump, more report old moves
constexpr std::size_t kDriftKeyframes = 10;
// Before the map has been adjusted: the expected move, as a share of the distance, and the number of
// keyframes that it counts as.
constexpr double kDriftYoungShare = 0.00015, kDriftYoungCounts = 2;

constexpr double kHalfQualityShare = 0.01;  // of the distance

}  // namespace

double QualityOf(double center_sigma, double distance) {
  return 1 / (1 + center_sigma / (kHalfQualityShare * std::max(1e-9, distance)));
}

double ErrorShareOf(double quality) { return kHalfQualityShare * (1 / std::clamp(quality, 1e-3, 1.0) - 1); }

double MapBend(double parallax) {
  constexpr double kAtOneRadian = 0.28;
  return kAtOneRadian / std::max(1e-3, parallax);
}

void MapDriftEstimate::Add(const Anchored& anchor, const Rigid3& cam_from_world) {
  given_.push_back({anchor, cam_from_world});
  if (given_.size() > kDriftKeyframes) given_.pop_front();
}

double MapDriftEstimate::CenterSigma(const Map& map, double distance) const {
  const double young = kDriftYoungShare, counts = kDriftYoungCounts;
  double sum = counts * young * young * distance * distance;
  for (const Given& given : given_)
    sum += (map.PoseOf(given.anchor).OriginInSource() - given.cam_from_world.OriginInSource()).squaredNorm();
  return std::sqrt(sum / (counts + static_cast<double>(given_.size())));
}

}  // namespace ulf::tracking
