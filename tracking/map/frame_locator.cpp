#include "tracking/map/frame_locator.h"

#include <spdlog/spdlog.h>

#include <Eigen/LU>
#include <algorithm>
#include <iterator>

#include "core/base/at.h"
#include "tracking/map/pose_log_odds.h"

namespace ulf::tracking {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// For so many corners of a frame one patch is tried where no corner was detected. Guessed.
constexpr int kLocatorCornersPerPatch = 5;
// Search radii: a pose that is good to a few pixels, and one that is not; descriptor distances for the
// frame before's points, and for all. Guessed.
constexpr double kLocatorFineRadiusPx = 4, kLocatorWideRadiusPx = 10;
constexpr int kLocatorFirstMaxDistance = 80, kLocatorMaxDistance = 70;
constexpr RefinePoseOptions kLocatorFirstRefinement = {.gate_sigmas = 3, .rounds = 2, .min_step = 1e-5};
// Relocalization: keyframes that are ranked, and tried until one shows where the camera is; other places
// that look alike and are asked whether the pose is ambiguous (a keyframe that shows less than this share
// of the points is another place). Guessed.
constexpr int kLocatorRanked = 100, kLocatorTried = 6, kLocatorOtherPlaces = 5;
constexpr double kLocatorOtherPlaceShare = 1.0 / 3;
// A detected corner this close (level pixels) to a point that its patch alone found is the same point.
// Guessed.
constexpr double kLocatorShadowPx = 3;

// Returns whether a match fits a pose within the pose's covariance and its own sigma.
bool Allows(const CameraModel& camera, const PoseRefinement& pose, const Vector3d& position,
            const PointMatch& match) {
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

// Drops matches that contradict the confirmed points. Where a part of the image moves on its own, two
// keyframes can agree about it, and its many new points would pull the pose and the next keyframes along. So
// an unconfirmed point counts only where the pose of the confirmed ones allows it. In a map that has just
// started no point is confirmed, and every match counts.
std::vector<PointMatch> FilterByConfirmedPoints(const CameraModel& camera, const FramePose& frame_pose,
                                                const std::vector<PointMatch>& matches,
                                                const std::vector<PointObservation>& corners,
                                                int min_matches) {
  std::vector<PointMatch> confirmed;
  std::copy_if(matches.begin(), matches.end(), std::back_inserter(confirmed),
               [&](const PointMatch& match) { return frame_pose.CandidateOf(match).confirmed; });
  if (confirmed.size() == matches.size()) return matches;
  std::vector<PointObservation> sure = ToObservations(frame_pose.candidates, confirmed);
  sure.insert(sure.end(), corners.begin(), corners.end());
  const auto pose = RefinePose(camera, sure, frame_pose.cam_from_world);
  if (!pose || pose->inliers < min_matches) return matches;
  std::vector<PointMatch> kept;
  std::copy_if(matches.begin(), matches.end(), std::back_inserter(kept), [&](const PointMatch& match) {
    const Candidate& candidate = frame_pose.CandidateOf(match);
    return candidate.confirmed || Allows(camera, *pose, candidate.position, match);
  });
  return kept;
}

}  // namespace

FrameLocator::FrameLocator(const CameraModel& camera, const SharedMap& shared, int corners)
    : camera_(camera), shared_(shared), undetected_(corners / kLocatorCornersPerPatch) {}

std::optional<FramePose> FrameLocator::Locate(const TrackedImage& image, const Rigid3& predicted, int part,
                                              double first_radius_px,
                                              const std::unordered_map<int, Vector2d>& first_points,
                                              StageTimes& stages) {
  StageTimer matching(&stages.matching_s);
  FramePose frame_pose;
  {
    const MapLock lock(shared_);
    frame_pose.candidates = GatherCandidatesNear(shared_.map, camera_, predicted, first_points, sweep_, part);
  }
  std::vector<int> first;
  for (int i = 0; i < static_cast<int>(frame_pose.candidates.size()); ++i)
    if (first_points.contains(frame_pose.candidates[At(i)].id)) first.push_back(i);
  if (first.empty()) return std::nullopt;

  const MapMatches coarse =
      MatchMap(camera_, image, frame_pose.candidates, first, predicted,
               {.radius_px = first_radius_px, .max_distance = kLocatorFirstMaxDistance});
  matching.Stop();
  StageTimer refinement(&stages.refinement_s);
  const auto refined = RefinePose(camera_, ToObservations(frame_pose.candidates, coarse.matches), predicted,
                                  kLocatorFirstRefinement);
  refinement.Stop();
  if (!refined || refined->inliers < kMinLocatedMatches) return std::nullopt;
  frame_pose.cam_from_world = refined->cam_from_world;
  return Refine(image, std::move(frame_pose), kLocatorFineRadiusPx * PxAt640(camera_.width), stages);
}

std::optional<FramePose> FrameLocator::Refine(const TrackedImage& image, FramePose frame_pose,
                                              double radius_px, StageTimes& stages) const {
  StageTimer matching(&stages.matching_s);
  MapMatches fine = MatchMap(camera_, image, frame_pose.candidates, {}, frame_pose.cam_from_world,
                             {.radius_px = radius_px, .max_distance = kLocatorMaxDistance});
  matching.Stop();
  StageTimer alignment(&stages.alignment_s);
  AlignMatches(camera_, image, frame_pose.candidates, frame_pose.cam_from_world, fine.matches);
  alignment.Stop();
  StageTimer refinement(&stages.refinement_s);
  const auto refine = [&](std::vector<PointMatch>& matches, const Rigid3& from) {
    const std::vector<PointObservation> corners = CornersOf(shared_, image, frame_pose.cam_from_world);
    matches = FilterByConfirmedPoints(camera_, frame_pose, matches, corners, kMinLocatedMatches);
    std::vector<PointObservation> all = ToObservations(frame_pose.candidates, matches);
    all.insert(all.end(), corners.begin(), corners.end());
    return RefinePose(camera_, all, from);
  };
  auto refined = refine(fine.matches, frame_pose.cam_from_world);
  if (!refined) return std::nullopt;
  frame_pose.matches = InliersOf(fine.matches, *refined);
  if (static_cast<int>(frame_pose.matches.size()) < kMinLocatedMatches) return std::nullopt;
  refinement.Stop();
  StageTimer search(&stages.alignment_s);
  const std::vector<int> looked_for =
      AlignUndetected(camera_, image, frame_pose.candidates, fine.expected, refined->cam_from_world,
                      undetected_, frame_pose.matches);
  search.Stop();
  StageTimer last(&stages.refinement_s);
  refined = refine(frame_pose.matches, refined->cam_from_world);
  if (!refined) return std::nullopt;
  frame_pose.cam_from_world = refined->cam_from_world;
  frame_pose.center_sigma = refined->center_sigma;
  frame_pose.matches = InliersOf(frame_pose.matches, *refined);
  if (frame_pose.matches.empty()) return std::nullopt;  // corners of fiducials alone say nothing of the map
  frame_pose.in_view = fine.expected;
  frame_pose.looked_for = looked_for;
  frame_pose.expected = 0;
  for (const int i : looked_for) frame_pose.expected += frame_pose.candidates[At(i)].find_rate;
  return frame_pose;
}

std::optional<FramePose> FrameLocator::FindAt(const TrackedImage& image, const Rigid3& cam_from_world) const {
  int part;
  {
    const MapLock lock(shared_);
    part = shared_.map.main_part();
  }
  std::optional<FramePose> found = FindNear(image, cam_from_world, part);
  if (!found || PoseLogOdds(camera_, *found) <= kFollowedLogOdds) return std::nullopt;
  return found;
}

std::optional<FramePose> FrameLocator::Find(const TrackedImage& image, const KeyframeIndex& index,
                                            unsigned seed) const {
  return FindAmong(index.Query(*image.features, kLocatorRanked), image, seed);
}

std::optional<FramePose> FrameLocator::FindInMainPart(const TrackedImage& image, const KeyframeIndex& index,
                                                      unsigned seed) const {
  std::vector<KeyframeIndex::Ranked> ranked = index.Query(*image.features, kLocatorRanked);
  {
    const MapLock lock(shared_);
    std::erase_if(ranked, [&](const KeyframeIndex::Ranked& r) ULF_REQUIRES(shared_.mutex) {
      return shared_.map.keyframe(r.keyframe).part != shared_.map.main_part();
    });
  }
  return FindAmong(ranked, image, seed);
}

std::optional<FramePose> FrameLocator::FindAmong(const std::vector<KeyframeIndex::Ranked>& ranked,
                                                 const TrackedImage& image, unsigned seed) const {
  for (int k = 0; k < std::min(kLocatorTried, static_cast<int>(ranked.size())); ++k) {
    const int keyframe = ranked[At(k)].keyframe;
    std::optional<FramePose> found = FindBy(keyframe, image, seed);
    if (!found) continue;
    ExcludedCandidates left_out;
    ExcludeAmbiguousMatches(camera_, *image.features, *found, left_out);
    ExcludeOtherPlaces(ranked, *found, left_out);
    const double evidence = PoseLogOdds(camera_, *found, left_out);
    spdlog::debug("keyframe {}: {} points of {:.0f}, evidence {:.1f}, without what repeats {:.1f}", keyframe,
                  found->matches.size(), found->expected, PoseLogOdds(camera_, *found), evidence);
    if (evidence > kRelocalizedLogOdds) return found;
  }
  return std::nullopt;
}

// Excludes matches that also fit keyframes of other places, which look like this image but share few points.
void FrameLocator::ExcludeOtherPlaces(const std::vector<KeyframeIndex::Ranked>& ranked,
                                      const FramePose& frame_pose, ExcludedCandidates& left_out) const {
  const MapLock lock(shared_);
  std::unordered_map<int, int> shows;  // by keyframe: how many of the points it sees
  for (const PointMatch& match : frame_pose.matches) {
    const int id = frame_pose.CandidateOf(match).id;
    for (const Observation& o : shared_.map.point(id).observations) ++shows[o.keyframe];
  }
  const int part = shared_.map.point(frame_pose.CandidateOf(frame_pose.matches.front()).id).part;
  int others = 0;
  for (const auto& [keyframe, votes] : ranked) {
    if (others >= kLocatorOtherPlaces) break;
    // Another part may show this very place.
    if (shared_.map.keyframe(keyframe).part != part) continue;
    if (shows[keyframe] > kLocatorOtherPlaceShare * static_cast<double>(frame_pose.matches.size())) continue;
    ++others;
    ExcludeAmbiguousMatches(shared_.map, keyframe, frame_pose, left_out);
  }
}

std::optional<FramePose> FrameLocator::FindBy(int keyframe, const TrackedImage& image, unsigned seed) const {
  KeyframePoints points;
  int part;
  {
    const MapLock lock(shared_);
    points = PointsOf(shared_.map, keyframe);
    part = shared_.map.keyframe(keyframe).part;
  }
  const auto proposal = ProposePose(camera_, points, *image.features, seed);
  return proposal ? FindNear(image, *proposal, part) : std::nullopt;
}

std::optional<FramePose> FrameLocator::FindNear(const TrackedImage& image, const Rigid3& cam_from_world,
                                                int part) const {
  FramePose frame_pose;
  frame_pose.cam_from_world = cam_from_world;
  {
    const MapLock lock(shared_);
    frame_pose.candidates = GatherCandidates(shared_.map, camera_, cam_from_world, part);
  }
  return RefineTwice(image, std::move(frame_pose));
}

std::optional<FramePose> FrameLocator::RefineTwice(const TrackedImage& image, FramePose frame_pose) const {
  StageTimes ignored;  // the caller counts all of this as one stage
  const double unit = PxAt640(camera_.width);
  std::optional<FramePose> wide = Refine(image, std::move(frame_pose), kLocatorWideRadiusPx * unit, ignored);
  return wide ? Refine(image, std::move(*wide), kLocatorFineRadiusPx * unit, ignored) : std::nullopt;
}

void FrameLocator::Describe(const FeatureSet& detected, const FramePose& frame_pose,
                            NewKeyframe& keyframe) const {
  std::vector<int> point_of(At(detected.size()), -1);
  std::vector<bool> shadowed(At(detected.size()), false);
  for (int m = 0; m < static_cast<int>(frame_pose.matches.size()); ++m) {
    const int feature = frame_pose.matches[At(m)].feature;
    if (feature >= 0) point_of[At(feature)] = m;
  }
  std::vector<Feature> features;
  const auto add = [&](const Feature& feature, int m) {
    if (m >= 0) {
      const PointMatch& match = frame_pose.matches[At(m)];
      keyframe.seen.push_back({frame_pose.CandidateOf(match).id,
                               {-1, static_cast<int>(features.size()), match.img, match.sigma_px}});
    }
    features.push_back(feature);
  };
  for (int m = 0; m < static_cast<int>(frame_pose.matches.size()); ++m) {
    const PointMatch& match = frame_pose.matches[At(m)];
    if (match.feature >= 0) continue;
    const auto ray = camera_.RayFromImg(match.img);
    if (!ray) continue;
    const Candidate& candidate = frame_pose.CandidateOf(match);
    const double distance = (frame_pose.cam_from_world * candidate.position).norm();
    const int level = NearestLevel(candidate.reference_distance / distance);
    detected.ForEachNear(match.img, kLocatorShadowPx * LevelScale(level), std::max(0, level - 1), level + 1,
                         [&](int i) { shadowed[At(i)] = true; });
    add({match.img, *ray, 0, level, candidate.descriptor}, m);
  }
  for (int i = 0; i < detected.size(); ++i)
    if (point_of[At(i)] >= 0 || !shadowed[At(i)]) add(detected[i], point_of[At(i)]);
  keyframe.keyframe.features =
      std::make_shared<const FeatureSet>(std::move(features), camera_.width, camera_.height);
}

}  // namespace ulf::tracking
