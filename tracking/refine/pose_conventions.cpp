#include "tracking/refine/pose_conventions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/estimation/two_view_motion.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;
using PoseChange = std::function<Rigid3(const Rigid3& cam_from_world)>;

// At least this share of the others must have a determined depth. Guessed.
constexpr double kLeastToldShare = 0.2;

std::optional<PoseFit> FitUnder(const PoseChange& change, const RefineScene& scene,
                                const std::vector<UnguidedPair>& pairs, std::size_t min_matches) {
  std::vector<double> medians;
  std::size_t near = 0, told = 0, before = 0;
  for (const UnguidedPair& pair : pairs) {
    if (pair.matches.size() < min_matches) continue;
    const RefineView &first = scene.view(pair.first), &second = scene.view(pair.second);
    const Rigid3 second_from_first = change(second.cam_from_world) * change(first.cam_from_world).Inverse();
    const Eigen::Matrix3d essential = EssentialFromPose(second_from_first);
    if (!(essential.norm() > 0)) continue;
    std::vector<double> errors;
    for (const FeatureMatch& match : pair.matches) {
      const RayPair rays{first.features[match.first].ray.normalized(),
                         second.features[match.second].ray.normalized()};
      errors.push_back(EpipolarError(essential, rays) * scene.LensOf(first).MeanFocalPx());
      if (errors.back() > kMostDepthErrorPx) continue;
      ++near;
      if (const auto depths = DepthsWhereRaysMeet(second_from_first, rays)) {
        ++told;
        before += depths->first > 0 && depths->second > 0;
      }
    }
    medians.push_back(Median(std::move(errors)));
  }
  if (medians.empty()) return std::nullopt;
  const bool is_told = told > 0 && static_cast<double>(told) >= kLeastToldShare * static_cast<double>(near);
  return PoseFit{Median(std::move(medians)),
                 is_told ? static_cast<double>(before) / static_cast<double>(told) : 1};
}

double LogBinomial(int n, int k) {
  return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
}

// Returns whether so many of the matches do not agree with a motion by chance: fewer than one in all motions
// through samples of this size would have as many, if matches lay anywhere (a contrario; Moisan and Stival,
// 2004). `chance`: the share of the picture that agrees with one motion.
bool IsNoChance(int agreeing, int matches, int sample, double chance) {
  if (agreeing <= sample) return false;
  constexpr int kMostSolutions = 10;
  return std::log(static_cast<double>(kMostSolutions) * (matches - sample)) + LogBinomial(matches, agreeing) +
             LogBinomial(agreeing, sample) + (agreeing - sample) * std::log(chance) <
         0;
}

// Returns whether the matches of a pair agree on a motion of the camera, found in them alone. The threshold
// is wide: a wrong lens bends true matches, too, while wrong ones are off by a part of the picture.
bool AgreesByItself(const RefineScene& scene, const UnguidedPair& pair) {
  constexpr double kThresholdShare = 0.01;  // of the picture's width. Guessed.
  const RefineView &first = scene.view(pair.first), &second = scene.view(pair.second);
  std::vector<RayPair> rays;
  for (const FeatureMatch& match : pair.matches)
    rays.push_back(
        {first.features[match.first].ray.normalized(), second.features[match.second].ray.normalized()});
  const CameraModel& lens = scene.LensOf(first);
  const double threshold_px = kThresholdShare * lens.width, area_px2 = 1.0 * lens.width * lens.height;
  const RelativePoseResult found =
      RelativePose(rays, {.focal_px = lens.MeanFocalPx(), .threshold_px = threshold_px});
  const double by_line = 2 * threshold_px * std::hypot(lens.width, lens.height) / area_px2,
               by_point = M_PI * threshold_px * threshold_px / area_px2;
  const int matches = static_cast<int>(rays.size());
  return IsNoChance(found.evidence.by_essential, matches, 5, by_line) ||
         IsNoChance(found.evidence.by_homography, matches, 4, by_point) ||
         IsNoChance(found.evidence.by_rotation, matches, 2, by_point);
}

Rigid3 WithYAndZTurned(const Rigid3& cam_from_world) {
  return Rigid3{Eigen::Quaterniond(0, 1, 0, 0), Vector3d::Zero()} * cam_from_world;
}

}  // namespace

std::optional<std::pair<double, double>> DepthsWhereRaysMeet(const Rigid3& second_from_first,
                                                             const RayPair& rays) {
  constexpr double kLeastSine = 0.01;  // of their angle
  const Rigid3 first_from_second = second_from_first.Inverse();
  const Vector3d &center = first_from_second.translation,
                 direction = first_from_second.rotation * rays.second;
  const Vector3d normal = rays.first.cross(direction);
  if (normal.norm() < kLeastSine) return std::nullopt;
  return std::pair(center.cross(direction).dot(normal) / normal.squaredNorm(),
                   center.cross(rays.first).dot(normal) / normal.squaredNorm());
}

bool IsPoor(const PoseFit& fit) {
  return fit.error_px > kMostFitErrorPx || fit.before_share < kLeastBeforeShare;
}

std::optional<PoseFit> FitOfPoses(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                                  std::size_t min_matches) {
  return FitUnder([](const Rigid3& pose) { return pose; }, scene, pairs, min_matches);
}

std::vector<UnguidedPair> PairsThatAgree(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                                         std::size_t min_matches) {
  constexpr std::size_t kMostTried = 60;
  std::vector<const UnguidedPair*> tried;
  for (const UnguidedPair& pair : pairs)
    if (pair.matches.size() >= min_matches) tried.push_back(&pair);
  const std::size_t count = std::min(kMostTried, tried.size());
  std::vector<char> agrees(count);
  ParallelFor(count, [&](std::size_t i) {
    agrees[i] = AgreesByItself(scene, *tried[i * tried.size() / count]) ? 1 : 0;
  });
  std::vector<UnguidedPair> agreeing;
  for (std::size_t i = 0; i < count; ++i)
    if (agrees[i] != 0) agreeing.push_back(*tried[i * tried.size() / count]);
  return agreeing;
}

std::string PoseConvention(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                           std::size_t min_matches) {
  // Turning the world changes nothing between two cameras, so these three are all that there are. The words
  // say how the file has the poses, and are true of every format: whatever axes a format means, poses that
  // fit once they are inverted have OpenCV's in the file, and those that fit once they are inverted and
  // turned OpenGL's.
  const std::pair<const char*, PoseChange> conventions[] = {
      {"the cameras' y and z axes point the other way (up and back, as in OpenGL, where the format means "
       "down and forward, as in OpenCV, or the reverse)",
       WithYAndZTurned},
      {"the poses are inverted (they lead from the world to the camera where the format means from the "
       "camera to the world, or the reverse), with the camera's y axis down and z forward, as in OpenCV",
       [](const Rigid3& pose) { return pose.Inverse(); }},
      {"the poses are inverted (they lead from the world to the camera where the format means from the "
       "camera to the world, or the reverse), with the camera's y axis up and z back, as in OpenGL",
       [](const Rigid3& pose) { return WithYAndZTurned(pose.Inverse()); }}};
  std::string best;
  double least = kMostFitErrorPx;
  for (const auto& [words, change] : conventions) {
    const auto fit = FitUnder(change, scene, pairs, min_matches);
    if (!fit || IsPoor(*fit) || fit->error_px >= least) continue;
    least = fit->error_px;
    best = words;
  }
  return best;
}

}  // namespace ulf::tracking
