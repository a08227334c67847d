#include "tracking/map/pose_error.h"

#include <algorithm>
#include <cmath>

namespace ulf::tracking {
namespace {

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
  if (given_.size() > options_.keyframes) given_.pop_front();
}

double MapDriftEstimate::CenterSigma(const Map& map, double distance) const {
  const double young = options_.young_share, counts = options_.young_counts;
  double sum = counts * young * young * distance * distance;
  for (const Given& given : given_)
    sum += (map.PoseOf(given.anchor).OriginInSource() - given.cam_from_world.OriginInSource()).squaredNorm();
  return std::sqrt(sum / (counts + static_cast<double>(given_.size())));
}

}  // namespace ulf::tracking
