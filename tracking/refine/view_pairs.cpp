#include "tracking/refine/view_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// MeasurePoseErrorPx(): pairs that are examined, matches that each needs, and the share of the pairs whose
// error the result covers. Guessed.
constexpr std::size_t kPoseErrorPairs = 24, kPoseErrorMinMatches = 20;
constexpr double kPoseErrorPairsWithin = 0.8;

// IsOnePlace(): pairs that are examined, and matches that each needs. Guessed.
constexpr std::size_t kOnePlacePairs = 24, kOnePlaceMinMatches = 30;
// A rotation explains a match within this distance, a pair by this share of its matches, because some are
// wrong, and all by this share of the pairs, because neighbours may lie very close together. Guessed.
constexpr double kOnePlaceTurnedPx = 2, kOnePlaceMatchShare = 0.7, kOnePlacePairShare = 0.9;

// MatchAroundPose() uses these, which are all guessed: the half widths of its two bands, in errors and in
// pixels.
constexpr double kAgreementWideErrors = 3, kAgreementNarrowPx = 2.5;
// The matches that agree must exceed those by chance this many times, and by so many.
constexpr double kAgreementChanceTimes = 3, kAgreementChanceMore = 10;
// The prior of the relative pose: standard deviations of its turn, in errors, and of its translation, as a
// share of the baseline. A wider one lets wrong matches pull further.
constexpr double kAgreementTurnErrors = 2, kAgreementShift = 0.3;
// Errors beyond the reach weigh less. It shrinks from the poses' error by this factor down to this size,
// with so many iterations at each. Faster shrinking ends at wrong poses more often.
constexpr double kAgreementShrink = 0.7, kAgreementLeastReachPx = 0.7;
constexpr int kAgreementIterations = 4;

// Matches that the two-view geometry confirms may be less sure than others. Guessed.
constexpr MatchOptions kEpipolarDescriptors = {.max_distance = 60, .max_ratio = 0.85};
// A second best this close to the best (pixels of level 0, growing with the level) is the same corner on
// another level, and no rival.
constexpr double kEpipolarSamePlacePx = 3;
constexpr int kEpipolarLevelsApart = 2;  // between the corners of a match; more is another thing

// Views that differ more, in parallax or direction, share too little. Guessed.
constexpr double kPairMaxApartDeg = 60;
constexpr double kPairTurnWeight = 0.3;  // the weight of the axes' angle beside the parallax. Guessed

// Returns the scene's distance, about: the cameras' distance from where their axes meet, else their spread.
double SceneDistance(const RefineScene& scene) {
  std::vector<RayObservation> axes;
  Vector3d middle = Vector3d::Zero();
  for (const RefineView& view : scene.views) {
    if (!view.registered) continue;
    axes.push_back({view.cam_from_world, Vector3d::UnitZ()});
    middle += view.cam_from_world.OriginInSource();
  }
  middle /= static_cast<double>(std::max<std::size_t>(1, axes.size()));
  const auto met = TriangulatePoint(axes);
  std::vector<double> distances;
  for (const RayObservation& axis : axes)
    distances.push_back((axis.cam_from_world.OriginInSource() - met.value_or(middle)).norm());
  return Median(std::move(distances));
}

// Another view, relative to one.
struct Neighbour {
  int view = 0;
  double apart = 0;   // parallax at the scene's distance plus a part of the axes' angle, radians
  int direction = 0;  // the image's quadrant in which its centre lies
};

std::vector<Neighbour> NeighboursOf(const RefineScene& scene, int index, double distance) {
  const RefineView& view = scene.view(index);
  const Vector3d axis = view.cam_from_world.DirectionInSource(Vector3d::UnitZ());
  std::vector<Neighbour> neighbours;
  for (int j = 0; j < static_cast<int>(scene.views.size()); ++j) {
    const RefineView& other = scene.view(j);
    if (j == index || !other.registered) continue;
    const Vector3d towards = view.cam_from_world * other.cam_from_world.OriginInSource();
    const double turned = AngleBetween(axis, other.cam_from_world.DirectionInSource(Vector3d::UnitZ()));
    const double parallax = std::atan(towards.norm() / std::max(1e-12, distance));
    if (std::max(turned, parallax) > Radians(kPairMaxApartDeg)) continue;
    const int direction = (towards.x() > 0) + 2 * (towards.y() > 0);
    neighbours.push_back({j, parallax + kPairTurnWeight * turned, direction});
  }
  return neighbours;
}

std::vector<RayPair> RaysOf(const RefineView& first, const RefineView& second,
                            const std::vector<FeatureMatch>& matches) {
  std::vector<RayPair> rays;
  for (const FeatureMatch& match : matches)
    rays.push_back({first.features[match.first].ray, second.features[match.second].ray});
  return rays;
}

// The nearest descriptor whose rival lies elsewhere in the image.
struct NearestElsewhere : NearestDescriptor {
  void OfferAt(int j, int d, const FeatureSet& features, double same_place_px) {
    if (d >= second) return;
    const bool same_place = index >= 0 && (features[j].img - features[index].img).squaredNorm() <
                                              same_place_px * same_place_px * (features[j].level + 1);
    if (d < distance) {
      if (!same_place) second = distance;
      distance = d;
      index = j;
    } else if (!same_place) {
      second = d;
    }
  }
};

double SignedEpipolarError(const Eigen::Matrix3d& essential, const RayPair& pair) {
  const Vector3d line = essential * pair.first, line_back = essential.transpose() * pair.second;
  const double scale = std::sqrt(line.squaredNorm() + line_back.squaredNorm());
  return scale > 0 ? pair.second.dot(line) / scale * std::sqrt(2.0) : 0;
}

// Returns the relative pose near `start` on which most pairs agree: Gauss-Newton with weights that fall
// beyond an error that shrinks from `error_px` to a pixel, and a prior as wide as the start is uncertain.
Rigid3 MoveToAgreement(const std::vector<RayPair>& pairs, const Rigid3& start, double focal_px,
                       double error_px) {
  const double length = start.translation.norm();
  Twist prior;
  prior << Vector3d::Constant(kAgreementTurnErrors * error_px / focal_px),
      Vector3d::Constant(kAgreementShift * length);
  Twist twist = Twist::Zero();
  const auto errors_at = [&](const Twist& at) {
    const Eigen::Matrix3d essential = EssentialFromPose(Perturbed(start, at));
    Eigen::VectorXd errors(static_cast<Eigen::Index>(pairs.size()));
    for (std::size_t i = 0; i < pairs.size(); ++i)
      errors(static_cast<Eigen::Index>(i)) = focal_px * SignedEpipolarError(essential, pairs[i]);
    return errors;
  };
  for (double reach_px = error_px; reach_px > kAgreementLeastReachPx; reach_px *= kAgreementShrink)
    for (int iteration = 0; iteration < kAgreementIterations; ++iteration) {
      const Eigen::VectorXd errors = errors_at(twist);
      std::array<Eigen::VectorXd, 6> slopes;
      for (int k = 0; k < 6; ++k) {
        const double step = 1e-5 * (k < 3 ? 1 : length);
        slopes[At(k)] = (errors_at(twist + step * Twist::Unit(k)) - errors) / step;
      }
      Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
      Twist right = Twist::Zero();
      for (Eigen::Index i = 0; i < errors.size(); ++i) {
        Twist j;
        for (int k = 0; k < 6; ++k) j(k) = slopes[At(k)](i);
        const double share = errors(i) / reach_px, weight = 1 / ((1 + share * share) * (1 + share * share));
        normal += weight * j * j.transpose();
        right -= weight * errors(i) * j;
      }
      for (int k = 0; k < 6; ++k) {
        const double weight = reach_px * reach_px / (prior(k) * prior(k));
        normal(k, k) += weight;
        right(k) -= weight * twist(k);
      }
      twist += SolveNormal(normal, right);
    }
  return Perturbed(start, twist);
}

}  // namespace

std::vector<std::pair<int, int>> ChoosePairs(const RefineScene& scene, const PairOptions& options) {
  const double distance = SceneDistance(scene);
  std::set<std::pair<int, int>> pairs;
  for (int i = 0; i < static_cast<int>(scene.views.size()); ++i) {
    if (!scene.view(i).registered) continue;
    std::vector<Neighbour> neighbours = NeighboursOf(scene, i, distance);
    std::ranges::stable_sort(neighbours, {}, &Neighbour::apart);
    const auto take = [&](int j) { pairs.insert({std::min(i, j), std::max(i, j)}); };
    for (int k = 0; k < std::min(options.nearest, static_cast<int>(neighbours.size())); ++k)
      take(neighbours[At(k)].view);
    for (int direction = 0; direction < 4; ++direction)
      for (const double wanted : {Radians(options.small_parallax_deg), Radians(options.large_parallax_deg)}) {
        const Neighbour* nearest = nullptr;
        for (const Neighbour& n : neighbours)
          if (n.direction == direction &&
              (!nearest || std::abs(n.apart - wanted) < std::abs(nearest->apart - wanted)))
            nearest = &n;
        if (nearest) take(nearest->view);
      }
  }
  return {pairs.begin(), pairs.end()};
}

std::vector<FeatureMatch> MatchAlongEpipolarLines(const FeatureSet& first, const FeatureSet& second,
                                                  const Rigid3& second_from_first, double focal_px,
                                                  double band_px) {
  Eigen::Matrix<float, Eigen::Dynamic, 3> rays(second.size(), 3);
  for (int j = 0; j < second.size(); ++j) rays.row(j) = second[j].ray.cast<float>();
  std::vector<NearestElsewhere> of_second(At(second.size()));
  std::vector<FeatureMatch> matches;
  Eigen::VectorXf off(second.size());
  const float band = static_cast<float>(band_px / focal_px);
  for (int i = 0; i < first.size(); ++i) {
    const Feature& feature = first[i];
    const Vector3d normal = second_from_first.translation.cross(second_from_first.rotation * feature.ray);
    if (!(normal.norm() > 1e-9 * second_from_first.translation.norm())) continue;
    off.noalias() = rays * normal.normalized().cast<float>();
    NearestElsewhere nearest;
    for (int j = 0; j < second.size(); ++j) {
      if (std::abs(off(j)) > band || std::abs(second[j].level - feature.level) > kEpipolarLevelsApart)
        continue;
      const int distance = Distance(feature.descriptor, second[j].descriptor);
      nearest.OfferAt(j, distance, second, kEpipolarSamePlacePx);
      of_second[At(j)].OfferAt(i, distance, first, kEpipolarSamePlacePx);
    }
    if (nearest.Passes(kEpipolarDescriptors)) matches.push_back({i, nearest.index, nearest.distance});
  }
  std::erase_if(matches,
                [&](const FeatureMatch& match) { return of_second[At(match.second)].index != match.first; });
  KeepSameRotation(first, second, matches);
  return matches;
}

PairMatches MatchAroundPose(const RefineScene& scene, int first, int second, double error_px,
                            int min_matches) {
  const RefineView &a = scene.view(first), &b = scene.view(second);
  PairMatches pair{first, second, {}, 0};
  const double focal_px = std::min(scene.LensOf(a).MeanFocalPx(), scene.LensOf(b).MeanFocalPx());
  const Rigid3 start = b.cam_from_world * a.cam_from_world.Inverse();
  const bool apart = start.translation.norm() > 0;
  const std::vector<FeatureMatch> matches =
      apart
          ? MatchAlongEpipolarLines(a.features, b.features, start, focal_px, kAgreementWideErrors * error_px)
          : MatchAll(a.features, AllOf(a.features), b.features, AllOf(b.features), kEpipolarDescriptors);
  pair.alike = static_cast<int>(matches.size());
  if (pair.alike < min_matches || !apart) return pair;
  const std::vector<RayPair> rays = RaysOf(a, b, matches);
  const Rigid3 moved = MoveToAgreement(rays, start, focal_px, error_px);
  // Matches by chance agree too: in proportion to the bands' widths, and some more because the pose moved to
  // where they are.
  const Eigen::Matrix3d essential = EssentialFromPose(moved);
  int agreeing = 0;
  for (const RayPair& ray : rays)
    agreeing += focal_px * std::abs(SignedEpipolarError(essential, ray)) < kAgreementNarrowPx;
  const double by_chance = pair.alike * std::min(1.0, kAgreementNarrowPx / (kAgreementWideErrors * error_px));
  if (agreeing < min_matches || agreeing < kAgreementChanceTimes * by_chance + kAgreementChanceMore)
    return pair;
  pair.matches = MatchAlongEpipolarLines(a.features, b.features, moved, focal_px, kAgreementNarrowPx);
  if (static_cast<int>(pair.matches.size()) < min_matches) pair.matches.clear();
  return pair;
}

bool IsOnePlace(const RefineScene& scene, const std::vector<PairMatches>& pairs, unsigned seed) {
  std::vector<const PairMatches*> usable;
  for (const PairMatches& pair : pairs)
    if (pair.matches.size() >= kOnePlaceMinMatches) usable.push_back(&pair);
  const std::size_t count = std::min(kOnePlacePairs, usable.size());
  std::vector<int> turned(count, 0);
  ParallelFor(count, [&](std::size_t k) {
    const PairMatches& pair = *usable[k * usable.size() / count];
    const RefineView &a = scene.view(pair.first), &b = scene.view(pair.second);
    const double focal_px = scene.LensOf(b).MeanFocalPx();
    const std::vector<RayPair> rays = RaysOf(a, b, pair.matches);
    const Eigen::Quaterniond turn =
        FitRotation(rays, focal_px, kOnePlaceTurnedPx, seed + static_cast<unsigned>(k));
    const auto explained = std::ranges::count_if(rays, [&](const RayPair& ray) {
      return (turn * ray.first - ray.second).norm() * focal_px < kOnePlaceTurnedPx;
    });
    turned[k] = static_cast<double>(explained) > kOnePlaceMatchShare * static_cast<double>(rays.size());
  });
  return count > 0 &&
         std::accumulate(turned.begin(), turned.end(), 0) > kOnePlacePairShare * static_cast<double>(count);
}

UnguidedPair MatchUnguided(const RefineScene& scene, int first, int second, const MatchOptions& options) {
  const RefineView &a = scene.view(first), &b = scene.view(second);
  const Eigen::Matrix3d essential = EssentialFromPose(b.cam_from_world * a.cam_from_world.Inverse());
  UnguidedPair pair{first, second, {}, {}};
  if (!(essential.norm() > 0)) return pair;
  pair.matches = MatchAll(a.features, AllOf(a.features), b.features, AllOf(b.features), options);
  for (const RayPair& ray : RaysOf(a, b, pair.matches))
    pair.errors_px.push_back(EpipolarError(essential, ray) * scene.LensOf(a).MeanFocalPx());
  return pair;
}

std::optional<double> MeasurePoseErrorPx(const RefineScene& scene,
                                         const std::vector<std::pair<int, int>>& pairs) {
  const std::size_t count = std::min(kPoseErrorPairs, pairs.size());
  std::vector<double> pair_errors(count, -1);
  ParallelFor(count, [&](std::size_t k) {
    const auto [first, second] = pairs[k * pairs.size() / count];
    std::vector<double> errors = MatchUnguided(scene, first, second).errors_px;
    if (errors.size() < kPoseErrorMinMatches) return;
    const double error = Median(std::move(errors)) / kMedianOfNormal;
    if (std::isfinite(error)) pair_errors[k] = error;
  });
  std::erase(pair_errors, -1);
  if (pair_errors.empty()) return std::nullopt;
  return Quantile(std::move(pair_errors), kPoseErrorPairsWithin);
}

}  // namespace ulf::tracking
