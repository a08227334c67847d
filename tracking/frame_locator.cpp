#include "tracking/frame_locator.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "tracking/matching.h"
#include "tracking/quantile.h"

namespace ulf {

using Eigen::Vector2d;

namespace {

// Fewer agreeing matches than this are not even a hint of a pose.
constexpr int kMinCoarse = 12;

std::vector<PointMatch> InliersOf(const std::vector<PointMatch>& matches, const PoseRefinement& refined) {
  std::vector<PointMatch> inliers;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (refined.inlier[i]) inliers.push_back(matches[i]);
  return inliers;
}

// Seen from either, what is matched lies where the other one has it.
bool SamePlace(const Located& a, const Located& b) {
  std::vector<double> apart;
  for (const PointMatch& match : a.matches) {
    const Eigen::Vector3d& point = a.candidates[static_cast<std::size_t>(match.candidate)].position;
    const Eigen::Vector3d in_a = a.cam_from_world * point;
    apart.push_back((in_a - b.cam_from_world * point).norm() / in_a.norm());
  }
  constexpr double kTolerance = 0.02;
  return Median(std::move(apart)) < kTolerance;
}

// A hand hides whole regions; a wrong pose misses points everywhere among those that it finds. The share
// found of what should be, where anything is.
double FillOf(const CameraModel& camera, const Located& located, double usual_share) {
  constexpr int kColumns = 4, kRows = 3;
  std::array<double, kColumns * kRows> expected{}, found{};
  const auto cell_of = [&](const Vector2d& img) {
    const int column = std::clamp(static_cast<int>(kColumns * img.x() / camera.width), 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(kRows * img.y() / camera.height), 0, kRows - 1);
    return static_cast<std::size_t>(row * kColumns + column);
  };
  const std::unordered_set<int> ids(located.expected_ids.begin(), located.expected_ids.end());
  for (const Candidate& candidate : located.candidates)
    if (ids.contains(candidate.id))
      if (const auto img = camera.ImgFromCam(located.cam_from_world * candidate.position))
        expected[cell_of(*img)] += candidate.find_rate;
  for (const PointMatch& match : located.matches) ++found[cell_of(match.img)];
  double sum_expected = 0, sum_found = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (found[i] < 2) continue;
    sum_expected += expected[i];
    sum_found += found[i];
  }
  return sum_expected > 0 ? sum_found / (usual_share * sum_expected) : 1;
}

// So much more of the image speaks for the first that the second is chance or a repetition; a first that
// itself misses a part of what it should see must be better still.
bool Outdoes(const CameraModel& camera, const Located& first, const Located& second, double usual_share) {
  const double margin = FillOf(camera, first, usual_share) > 0.85 ? 0.8 : 0.6;
  return static_cast<double>(second.matches.size()) < margin * static_cast<double>(first.matches.size());
}

}  // namespace

std::optional<Located> FrameLocator::Locate(const TrackedImage& image, const Rigid3& predicted,
                                            double first_radius_px,
                                            const std::unordered_map<int, Vector2d>& first_points,
                                            StageTimes& stages) {
  StageTimer matching(&stages.matching_s);
  Located located;
  {
    const std::lock_guard lock(shared_.mutex);
    located.candidates = GatherCandidatesNear(shared_.map, camera_, predicted, first_points, sweep_);
  }
  std::vector<int> first;
  for (int i = 0; i < static_cast<int>(located.candidates.size()); ++i)
    if (first_points.contains(located.candidates[static_cast<std::size_t>(i)].id)) first.push_back(i);
  if (first.empty()) return std::nullopt;

  const MapMatches coarse = MatchMap(camera_, image, located.candidates, first, predicted,
                                     {.radius_px = first_radius_px, .max_distance = 80, .align = false});
  matching.Stop();
  StageTimer refinement(&stages.refinement_s);
  const auto refined = RefinePose(camera_, ToObservations(located.candidates, coarse.matches), predicted,
                                  {.gate_sigmas = 3, .rounds = 2, .min_step = 1e-5});
  refinement.Stop();
  if (!refined || refined->inliers < kMinCoarse) return std::nullopt;
  located.cam_from_world = refined->cam_from_world;
  return Refine(image, std::move(located), 4 * camera_.width / 640.0, stages);
}

std::optional<Located> FrameLocator::Refine(const TrackedImage& image, Located located, double radius_px,
                                            StageTimes& stages) const {
  StageTimer matching(&stages.matching_s);
  MapMatches fine = MatchMap(camera_, image, located.candidates, {}, located.cam_from_world,
                             {.radius_px = radius_px, .max_distance = 70, .align = false});
  matching.Stop();
  StageTimer alignment(&stages.alignment_s);
  AlignMatches(camera_, image, located.candidates, located.cam_from_world, fine.matches);
  alignment.Stop();
  StageTimer refinement(&stages.refinement_s);
  auto refined =
      RefinePose(camera_, ToObservations(located.candidates, fine.matches), located.cam_from_world);
  if (!refined || refined->inliers < kMinCoarse) return std::nullopt;
  located.matches = InliersOf(fine.matches, *refined);
  refinement.Stop();
  StageTimer search(&stages.alignment_s);
  AlignUndetected(camera_, image, located.candidates, fine.expected, refined->cam_from_world,
                  most_undetected_, located.matches);
  search.Stop();
  StageTimer last(&stages.refinement_s);
  refined = RefinePose(camera_, ToObservations(located.candidates, located.matches), refined->cam_from_world);
  if (!refined) return std::nullopt;
  located.cam_from_world = refined->cam_from_world;
  located.center_sigma = refined->center_sigma;
  located.matches = InliersOf(located.matches, *refined);
  located.expected = 0;
  located.expected_ids.clear();
  for (const int i : fine.expected) {
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(i)];
    located.expected += candidate.find_rate;
    located.expected_ids.push_back(candidate.id);
  }
  return located;
}

std::optional<Located> FrameLocator::Find(const TrackedImage& image, const KeyframeIndex& index,
                                          unsigned seed, int min_points) const {
  constexpr int kRanked = 100;
  constexpr int kTried = 6;       // keyframes, until one shows where this is
  constexpr int kRivals = 3;      // and others, which may show that it could be elsewhere
  constexpr double kAlike = 0.3;  // of the best keyframe's votes: less is no rival
  const std::vector<KeyframeIndex::Ranked> ranked = index.Query(*image.features, kRanked);
  const double usual = shared_.usual_share;
  std::optional<Located> best;
  std::unordered_map<int, int> shown;  // by keyframe: how many of the best one's points it sees
  int tried = 0, rivals = 0;
  for (const auto& [keyframe, votes] : ranked) {
    if (best ? rivals >= kRivals || votes < kAlike * ranked.front().votes : tried >= kTried) break;
    if (best && 3 * shown[keyframe] > static_cast<int>(best->matches.size())) continue;
    ++(best ? rivals : tried);
    std::optional<Located> found = FindBy(keyframe, image, seed, min_points);
    if (!found) continue;
    if (best && SamePlace(*best, *found)) continue;
    if (best && !Outdoes(camera_, *best, *found, usual) && !Outdoes(camera_, *found, *best, usual)) {
      spdlog::debug("keyframe {} shows another place that looks as much like it: {} points and {}", keyframe,
                    found->matches.size(), best->matches.size());
      return std::nullopt;
    }
    if (best && !Outdoes(camera_, *found, *best, usual)) continue;
    spdlog::debug("found by keyframe {} with {} points of {:.0f}", keyframe, found->matches.size(),
                  found->expected);
    best = std::move(found);
    shown.clear();
    const std::lock_guard lock(shared_.mutex);
    for (const PointMatch& match : best->matches) {
      const int id = best->candidates[static_cast<std::size_t>(match.candidate)].id;
      for (const Observation& o : shared_.map.point(id).observations) ++shown[o.keyframe];
    }
  }
  return best;
}

std::optional<Located> FrameLocator::FindBy(int keyframe, const TrackedImage& image, unsigned seed,
                                            int min_points) const {
  StageTimes ignored;  // the caller counts all of this as one stage
  const double unit = camera_.width / 640.0;
  KeyframePoints points;
  {
    const std::lock_guard lock(shared_.mutex);
    points = PointsOf(shared_.map, keyframe);
  }
  const auto proposal = ProposePose(camera_, points, *image.features, seed);
  if (!proposal) return std::nullopt;
  Located located;
  located.cam_from_world = proposal->cam_from_world;
  {
    const std::lock_guard lock(shared_.mutex);
    located.candidates = GatherCandidates(shared_.map, camera_, proposal->cam_from_world);
  }
  std::optional<Located> wide = Refine(image, std::move(located), 10 * unit, ignored);
  if (!wide) return std::nullopt;
  std::optional<Located> found = Refine(image, std::move(*wide), 4 * unit, ignored);
  if (!found || !IsSure(*found, min_points) || FillOf(camera_, *found, shared_.usual_share) < 0.5 ||
      !IsDistinctive(*image.features, *found))
    return std::nullopt;
  return found;
}

bool IsDistinctive(const FeatureSet& features, const Located& located) {
  constexpr int kAlikeBits = 40;
  constexpr double kLeastShare = 0.3;
  int detected = 0, distinct = 0;
  for (const PointMatch& match : located.matches) {
    if (match.feature < 0) continue;
    ++detected;
    distinct += !HasTwin(features, match.feature, kAlikeBits);
  }
  return distinct >= kLeastShare * detected;
}

bool IsSure(const Located& located, int min_points) {
  const auto points = static_cast<double>(located.matches.size());
  return points >= min_points && points >= 0.3 * located.expected;
}

void FrameLocator::Describe(const FeatureSet& detected, const Located& located, NewKeyframe& keyframe) const {
  std::vector<int> point_of(static_cast<std::size_t>(detected.size()), -1);
  std::vector<bool> shadowed(static_cast<std::size_t>(detected.size()), false);
  for (int m = 0; m < static_cast<int>(located.matches.size()); ++m) {
    const int feature = located.matches[static_cast<std::size_t>(m)].feature;
    if (feature >= 0) point_of[static_cast<std::size_t>(feature)] = m;
  }
  std::vector<Feature> features;
  const auto add = [&](const Feature& feature, int m) {
    if (m >= 0) {
      const PointMatch& match = located.matches[static_cast<std::size_t>(m)];
      keyframe.seen.push_back({located.candidates[static_cast<std::size_t>(match.candidate)].id,
                               {-1, static_cast<int>(features.size()), match.img, match.sigma_px}});
    }
    features.push_back(feature);
  };
  for (int m = 0; m < static_cast<int>(located.matches.size()); ++m) {
    const PointMatch& match = located.matches[static_cast<std::size_t>(m)];
    if (match.feature >= 0) continue;
    const auto ray = camera_.RayFromImg(match.img);
    if (!ray) continue;
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(match.candidate)];
    const double distance = (located.cam_from_world * candidate.position).norm();
    const int level = NearestLevel(candidate.reference_distance / distance);
    constexpr double kShadowPx = 3;
    detected.ForEachNear(match.img, kShadowPx * LevelScale(level), std::max(0, level - 1), level + 1,
                         [&](int i) { shadowed[static_cast<std::size_t>(i)] = true; });
    add({match.img, *ray, 0, level, candidate.descriptor}, m);
  }
  for (int i = 0; i < detected.size(); ++i)
    if (point_of[static_cast<std::size_t>(i)] >= 0 || !shadowed[static_cast<std::size_t>(i)])
      add(detected[i], point_of[static_cast<std::size_t>(i)]);
  keyframe.keyframe.features =
      std::make_shared<const FeatureSet>(std::move(features), camera_.width, camera_.height);
}

}  // namespace ulf
