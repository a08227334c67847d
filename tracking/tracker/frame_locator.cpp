#include "tracking/tracker/frame_locator.h"

#include <spdlog/spdlog.h>

#include <Eigen/LU>
#include <algorithm>
#include <iterator>
#include <limits>

#include "core/base/quantile.h"
#include "tracking/estimation/pose_log_odds.h"

namespace ulf::tracking {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Fewer agreeing matches than this are not even a hint of a pose.
constexpr int kMinCoarse = 12;

std::vector<PointMatch> InliersOf(const std::vector<PointMatch>& matches, const PoseRefinement& refined) {
  std::vector<PointMatch> inliers;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (refined.inlier[i]) inliers.push_back(matches[i]);
  return inliers;
}

const Candidate& CandidateOf(const FramePose& located, const PointMatch& match) {
  return located.candidates[static_cast<std::size_t>(match.candidate)];
}

// Whether a point may be seen there from a pose that is as unsure as it says.
bool Allows(const CameraModel& camera, const PoseRefinement& pose, const Vector3d& position,
            const PointMatch& match) {
  constexpr double kChi2 = 5.99;  // 95 % in two dimensions
  const Vector3d in_cam = pose.cam_from_world * position;
  Eigen::Matrix<double, 2, 3> img_by_point;
  const auto img = camera.ImgFromCam(in_cam, &img_by_point);
  if (!img) return false;
  Eigen::Matrix<double, 2, 6> img_by_twist;
  for (int row = 0; row < 2; ++row)
    img_by_twist.row(row) << in_cam.transpose().cross(img_by_point.row(row)), img_by_point.row(row);
  const Eigen::Matrix2d variance = img_by_twist * pose.covariance * img_by_twist.transpose() +
                                   match.sigma_px * match.sigma_px * Eigen::Matrix2d::Identity();
  const Vector2d off = *img - match.img;
  return off.dot(variance.inverse() * off) <= kChi2;
}

// Without what contradicts the points that are confirmed. Where a part of the picture moves on its own, two
// keyframes can agree about all of it, and so many new points at once would draw the pose, and the keyframes
// that follow, over to them: they count where they are found at a place that the confirmed ones allow. In a
// map that has just been started nothing is confirmed, and everything counts.
std::vector<PointMatch> FilterByConfirmedPoints(const CameraModel& camera, const FramePose& located,
                                                const std::vector<PointMatch>& matches,
                                                const std::vector<PointObservation>& corners) {
  std::vector<PointMatch> confirmed;
  std::copy_if(matches.begin(), matches.end(), std::back_inserter(confirmed),
               [&](const PointMatch& match) { return CandidateOf(located, match).confirmed; });
  if (confirmed.size() == matches.size()) return matches;
  std::vector<PointObservation> sure = ToObservations(located.candidates, confirmed);
  sure.insert(sure.end(), corners.begin(), corners.end());
  const auto pose = RefinePose(camera, sure, located.cam_from_world);
  if (!pose || pose->inliers < kMinCoarse) return matches;
  std::vector<PointMatch> kept;
  std::copy_if(matches.begin(), matches.end(), std::back_inserter(kept), [&](const PointMatch& match) {
    const Candidate& candidate = CandidateOf(located, match);
    return candidate.confirmed || Allows(camera, *pose, candidate.position, match);
  });
  return kept;
}

}  // namespace

double MedianShiftPx(const CameraModel& camera, const FramePose& located, const Rigid3& cam_from_world) {
  std::vector<double> shifts;
  for (const PointMatch& match : located.matches) {
    if (const auto img = camera.ImgFromCam(cam_from_world * CandidateOf(located, match).position))
      shifts.push_back((*img - match.img).norm());
  }
  return shifts.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(shifts));
}

std::optional<FramePose> FrameLocator::Locate(const TrackedImage& image, const Rigid3& predicted,
                                              double first_radius_px,
                                              const std::unordered_map<int, Vector2d>& first_points,
                                              StageTimes& stages) {
  StageTimer matching(&stages.matching_s);
  FramePose located;
  {
    const MapLock lock(shared_);
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

std::optional<FramePose> FrameLocator::Refine(const TrackedImage& image, FramePose located, double radius_px,
                                              StageTimes& stages) const {
  StageTimer matching(&stages.matching_s);
  MapMatches fine = MatchMap(camera_, image, located.candidates, {}, located.cam_from_world,
                             {.radius_px = radius_px, .max_distance = 70, .align = false});
  matching.Stop();
  StageTimer alignment(&stages.alignment_s);
  AlignMatches(camera_, image, located.candidates, located.cam_from_world, fine.matches);
  alignment.Stop();
  StageTimer refinement(&stages.refinement_s);
  const auto refine = [&](std::vector<PointMatch>& matches, const Rigid3& from) {
    const std::vector<PointObservation> corners = CornersOf(shared_, image, located.cam_from_world);
    matches = FilterByConfirmedPoints(camera_, located, matches, corners);
    std::vector<PointObservation> all = ToObservations(located.candidates, matches);
    all.insert(all.end(), corners.begin(), corners.end());
    return RefinePose(camera_, all, from);
  };
  auto refined = refine(fine.matches, located.cam_from_world);
  if (!refined) return std::nullopt;
  located.matches = InliersOf(fine.matches, *refined);
  if (static_cast<int>(located.matches.size()) < kMinCoarse) return std::nullopt;
  refinement.Stop();
  StageTimer search(&stages.alignment_s);
  const std::vector<int> looked_for =
      AlignUndetected(camera_, image, located.candidates, fine.expected, refined->cam_from_world,
                      most_undetected_, located.matches);
  search.Stop();
  StageTimer last(&stages.refinement_s);
  refined = refine(located.matches, refined->cam_from_world);
  if (!refined) return std::nullopt;
  located.cam_from_world = refined->cam_from_world;
  located.center_sigma = refined->center_sigma;
  located.matches = InliersOf(located.matches, *refined);
  located.in_view = fine.expected;
  located.looked_for = looked_for;
  located.expected = 0;
  for (const int i : looked_for)
    located.expected += located.candidates[static_cast<std::size_t>(i)].find_rate;
  return located;
}

std::optional<FramePose> FrameLocator::FindAt(const TrackedImage& image, const Rigid3& cam_from_world) const {
  std::optional<FramePose> found = RefineTwice(image, cam_from_world);
  if (!found || PoseLogOdds(camera_, *found) <= kFollowedLogOdds) return std::nullopt;
  return found;
}

std::optional<FramePose> FrameLocator::Find(const TrackedImage& image, const KeyframeIndex& index,
                                            unsigned seed) const {
  constexpr int kTried = 6;  // keyframes, until one shows where this is
  constexpr int kRanked = 100;
  const std::vector<KeyframeIndex::Ranked> ranked = index.Query(*image.features, kRanked);
  for (int k = 0; k < std::min(kTried, static_cast<int>(ranked.size())); ++k) {
    const int keyframe = ranked[static_cast<std::size_t>(k)].keyframe;
    std::optional<FramePose> found = FindBy(keyframe, image, seed);
    if (!found) continue;
    LeftOut left_out;
    ExcludeAmbiguousMatches(camera_, *image.features, *found, left_out);
    ExcludeOtherPlaces(ranked, *found, left_out);
    const double evidence = PoseLogOdds(camera_, *found, left_out);
    spdlog::debug("keyframe {}: {} points of {:.0f}, evidence {:.1f}, without what repeats {:.1f}", keyframe,
                  found->matches.size(), found->expected, PoseLogOdds(camera_, *found), evidence);
    if (evidence > kRelocalizedLogOdds) return found;
  }
  return std::nullopt;
}

// The keyframes that look like this picture without seeing what it was found by.
void FrameLocator::ExcludeOtherPlaces(const std::vector<KeyframeIndex::Ranked>& ranked,
                                      const FramePose& located, LeftOut& left_out) const {
  constexpr std::size_t kOthers = 5;
  const MapLock lock(shared_);
  std::unordered_map<int, std::size_t> shows;  // by keyframe: how many of the points it sees
  for (const PointMatch& match : located.matches) {
    const int id = CandidateOf(located, match).id;
    for (const Observation& o : shared_.map.point(id).observations) ++shows[o.keyframe];
  }
  std::size_t others = 0;
  for (const auto& [keyframe, votes] : ranked) {
    if (others >= kOthers) break;
    if (3 * shows[keyframe] > located.matches.size()) continue;
    ++others;
    ExcludeAmbiguousMatches(shared_.map, keyframe, located, left_out);
  }
}

std::optional<FramePose> FrameLocator::FindBy(int keyframe, const TrackedImage& image, unsigned seed) const {
  KeyframePoints points;
  {
    const MapLock lock(shared_);
    points = PointsOf(shared_.map, keyframe);
  }
  const auto proposal = ProposePose(camera_, points, *image.features, seed);
  if (!proposal) return std::nullopt;
  return RefineTwice(image, proposal->cam_from_world);
}

std::optional<FramePose> FrameLocator::RefineTwice(const TrackedImage& image,
                                                   const Rigid3& cam_from_world) const {
  StageTimes ignored;  // the caller counts all of this as one stage
  const double unit = camera_.width / 640.0;
  FramePose located;
  located.cam_from_world = cam_from_world;
  {
    const MapLock lock(shared_);
    located.candidates = GatherCandidates(shared_.map, camera_, cam_from_world);
  }
  std::optional<FramePose> wide = Refine(image, std::move(located), 10 * unit, ignored);
  if (!wide) return std::nullopt;
  return Refine(image, std::move(*wide), 4 * unit, ignored);
}

void FrameLocator::Describe(const FeatureSet& detected, const FramePose& located,
                            NewKeyframe& keyframe) const {
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
      keyframe.seen.push_back({CandidateOf(located, match).id,
                               {-1, static_cast<int>(features.size()), match.img, match.sigma_px}});
    }
    features.push_back(feature);
  };
  for (int m = 0; m < static_cast<int>(located.matches.size()); ++m) {
    const PointMatch& match = located.matches[static_cast<std::size_t>(m)];
    if (match.feature >= 0) continue;
    const auto ray = camera_.RayFromImg(match.img);
    if (!ray) continue;
    const Candidate& candidate = CandidateOf(located, match);
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

}  // namespace ulf::tracking
