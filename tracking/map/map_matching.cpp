#include "tracking/map/map_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"

namespace ulf::tracking {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// A projection may lie so far outside the image: the pose is a prediction. Guessed
constexpr double kCandidateMarginPx = 60;
constexpr double kCandidateMaxViewChangeDeg = 60;  // from the mean direction the point was seen in. Guessed
// Factors on the distances at which the pyramid shows the point, for a predicted pose. Guessed.
constexpr double kCandidateNearestShare = 0.8, kCandidateFarthestShare = 1.25;
// GatherCandidatesNear: those that see most of the frame before. Guessed
constexpr int kCandidateKeyframes = 20;

constexpr double kMapMatchMaxRatio = 0.9;

constexpr double kUndetectedCellPx = 32;  // matches are spread over cells of this side. Guessed
// Without a detected corner a patch must lie closer to its prediction, and look more alike, than with one.
// Guessed.
constexpr PatchAlignmentOptions kUndetectedAlignment = {.max_shift = 2, .min_correlation = 0.9};

class Gatherer {
 public:
  Gatherer(const CameraModel& camera, const Rigid3& cam_from_world, int part)
      : camera_(camera),
        part_(part),
        center_(cam_from_world.OriginInSource()),
        rotation_(cam_from_world.RotationMatrix()),
        axis_(cam_from_world.DirectionInSource(Vector3d::UnitZ())),
        widest_cosine_(std::cos(
            std::min(M_PI, camera.MaxRayAngle() + std::atan(2 * kCandidateMarginPx / camera.MeanFocalPx())))),
        min_cosine_(std::cos(Radians(kCandidateMaxViewChangeDeg))) {}

  void Offer(const MapPoint& point) {
    if (!point.alive || point.part != part_) return;
    const Vector3d towards = point.position - center_;
    const double distance = towards.norm();
    // This test comes first: it drops most points of a large map and reads little memory.
    if (towards.dot(axis_) < widest_cosine_ * distance) return;
    if (distance < kCandidateNearestShare * point.nearest ||
        distance > kCandidateFarthestShare * point.farthest)
      return;
    if (towards.dot(point.mean_direction) < min_cosine_ * distance) return;
    const auto img = camera_.ImgFromCam(rotation_ * towards);
    if (!img || img->x() < -kCandidateMarginPx || img->y() < -kCandidateMarginPx ||
        img->x() > camera_.width + kCandidateMarginPx || img->y() > camera_.height + kCandidateMarginPx)
      return;
    candidates_.push_back({point.id, point.position, point.mean_direction, point.descriptor,
                           point.reference_distance, point.nearest, point.farthest,
                           (point.found + 1.0) / (point.expected + 2.0), point.patch, point.patch_axes,
                           point.expected, point.observations.size() > 2});
  }
  std::vector<Candidate> Candidates() && { return std::move(candidates_); }

 private:
  const CameraModel& camera_;
  int part_;
  Vector3d center_;
  Eigen::Matrix3d rotation_;
  Vector3d axis_;
  double widest_cosine_;  // of the largest angle from the axis in the image with its margin
  double min_cosine_;
  std::vector<Candidate> candidates_;
};

// Returns the keyframes that see most of these points, by id.
std::vector<int> KeyframesSeeing(const Map& map, const std::unordered_map<int, Vector2d>& points, int most) {
  std::vector<int> seen(map.keyframes().size(), 0);
  for (const auto& [id, img] : points)
    if (const int alive = map.Resolve(id); alive >= 0)
      for (const Observation& o : map.point(alive).observations) ++seen[At(o.keyframe)];
  std::vector<int> chosen;
  for (int k = 0; k < static_cast<int>(seen.size()); ++k)
    if (seen[At(k)] > 0) chosen.push_back(k);
  if (static_cast<int>(chosen.size()) > most) {
    std::nth_element(chosen.begin(), chosen.begin() + most, chosen.end(), [&](int a, int b) {
      const int in_a = seen[At(a)], in_b = seen[At(b)];
      return in_a != in_b ? in_a > in_b : a > b;
    });
    chosen.resize(At(most));
  }
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace

std::vector<Candidate> GatherCandidates(const Map& map, const CameraModel& camera,
                                        const Rigid3& cam_from_world, int part) {
  Gatherer gatherer(camera, cam_from_world, part);
  for (const MapPoint& point : map.points()) gatherer.Offer(point);
  return std::move(gatherer).Candidates();
}

std::vector<Candidate> GatherCandidatesNear(const Map& map, const CameraModel& camera,
                                            const Rigid3& cam_from_world,
                                            const std::unordered_map<int, Vector2d>& seen_before, int& sweep,
                                            int part) {
  const int count = static_cast<int>(map.points().size());
  if (count <= kSweptPoints) return GatherCandidates(map, camera, cam_from_world, part);
  Gatherer gatherer(camera, cam_from_world, part);
  std::vector<bool> offered(At(count), false);
  const auto offer = [&](int id) {
    if (offered[At(id)]) return;
    offered[At(id)] = true;
    gatherer.Offer(map.point(id));
  };
  for (const int keyframe : KeyframesSeeing(map, seen_before, kCandidateKeyframes))
    for (const int id : map.keyframe(keyframe).point_of_feature)
      if (id >= 0) offer(id);
  if (sweep >= count) sweep = 0;
  for (int k = 0; k < kSweptPoints; ++k) {
    offer(sweep);
    sweep = (sweep + 1) % count;
  }
  return std::move(gatherer).Candidates();
}

MapMatches MatchMap(const CameraModel& camera, const TrackedImage& image,
                    std::span<const Candidate> candidates, std::span<const int> only,
                    const Rigid3& cam_from_world, const MapMatchOptions& options) {
  MapMatches result;
  std::vector<Expected> expected;
  std::vector<int> candidate_of;  // by entry of `expected`
  const Vector3d center = cam_from_world.OriginInSource();
  const auto consider = [&](int index) {
    const Candidate& candidate = candidates[At(index)];
    const double distance = (candidate.position - center).norm();
    if (distance < candidate.nearest || distance > candidate.farthest) return;
    const auto img = camera.ImgFromCam(cam_from_world * candidate.position);
    if (!img || !camera.Contains(*img)) return;
    const int level = NearestLevel(candidate.reference_distance / distance);
    if (img->x() >= kFeatureBorder && img->y() >= kFeatureBorder &&
        img->x() < camera.width - kFeatureBorder && img->y() < camera.height - kFeatureBorder)
      result.expected.push_back(index);
    expected.push_back({*img, options.radius_px * LevelScale(level), std::max(0, level - 1),
                        std::min(kPyramidLevels - 1, level + 1), &candidate.descriptor});
    candidate_of.push_back(index);
  };
  if (only.empty())
    for (int i = 0; i < static_cast<int>(candidates.size()); ++i) consider(i);
  else
    for (const int i : only) consider(i);

  const std::vector<int> features = MatchExpected(
      expected, *image.features, {.max_distance = options.max_distance, .max_ratio = kMapMatchMaxRatio});
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features[i] < 0) continue;
    const Feature& feature = (*image.features)[features[i]];
    PointMatch match{candidate_of[i], features[i], feature.img, DetectedSigmaPx(feature.level), false};
    if (image.pyramid && image.pyramid->rows) {  // with the point's own depth instead of a guess
      const Vector3d in_cam = cam_from_world * candidates[At(match.candidate)].position;
      match.img = image.pyramid->Global(image.pyramid->Seen(feature.img), &in_cam);
    }
    result.matches.push_back(match);
  }
  return result;
}

void AlignMatches(const CameraModel& camera, const TrackedImage& image, std::span<const Candidate> candidates,
                  const Rigid3& cam_from_world, std::vector<PointMatch>& matches) {
  for (PointMatch& match : matches) {
    const Candidate& candidate = candidates[At(match.candidate)];
    if (!candidate.patch) continue;
    const auto aligned = AlignPatch(camera, *candidate.patch, candidate.patch_axes, candidate.position,
                                    cam_from_world, *image.pyramid, match.img);
    if (!aligned) continue;
    match.img = aligned->img;
    match.sigma_px = AlignedSigmaPx(aligned->level);
    match.aligned = true;
  }
}

std::vector<int> AlignUndetected(const CameraModel& camera, const TrackedImage& image,
                                 std::span<const Candidate> candidates, std::span<const int> expected,
                                 const Rigid3& cam_from_world, int most, std::vector<PointMatch>& matches) {
  const int columns = static_cast<int>(camera.width / kUndetectedCellPx) + 1;
  const int rows = static_cast<int>(camera.height / kUndetectedCellPx) + 1;
  const int per_cell = 1 + (most + static_cast<int>(matches.size())) / (columns * rows / 2);
  std::vector<int> in_cell(At(columns * rows), 0);
  const auto cell_of = [&](const Vector2d& img) {
    return At(static_cast<int>(img.y() / kUndetectedCellPx) * columns +
              static_cast<int>(img.x() / kUndetectedCellPx));
  };
  std::vector<bool> matched(candidates.size(), false);
  for (const PointMatch& match : matches) {
    matched[At(match.candidate)] = true;
    if (camera.Contains(match.img)) ++in_cell[cell_of(match.img)];
  }
  std::vector<int> open, looked_for;
  for (const int i : expected) {
    const bool by_patch = !matched[At(i)] && candidates[At(i)].patch;
    (by_patch ? open : looked_for).push_back(i);
  }
  std::ranges::stable_sort(
      open, [&](int a, int b) { return candidates[At(a)].find_rate > candidates[At(b)].find_rate; });
  int tried = 0;
  for (const int i : open) {
    if (tried >= most) break;
    const Candidate& candidate = candidates[At(i)];
    const auto img = camera.ImgFromCam(cam_from_world * candidate.position);
    if (!img || !camera.Contains(*img)) continue;
    int& crowd = in_cell[cell_of(*img)];
    if (crowd >= per_cell) continue;
    ++tried;
    looked_for.push_back(i);
    const auto aligned = AlignPatch(camera, *candidate.patch, candidate.patch_axes, candidate.position,
                                    cam_from_world, *image.pyramid, *img, kUndetectedAlignment);
    if (!aligned) continue;
    ++crowd;
    matches.push_back({i, -1, aligned->img, AlignedSigmaPx(aligned->level), true});
  }
  return looked_for;
}

std::vector<PointObservation> ToObservations(std::span<const Candidate> candidates,
                                             std::span<const PointMatch> matches) {
  std::vector<PointObservation> observations;
  observations.reserve(matches.size());
  for (const PointMatch& match : matches)
    observations.push_back({candidates[At(match.candidate)].position, match.img, match.sigma_px});
  return observations;
}

std::vector<PointObservation> CornersOf(const SharedMap& shared, const TrackedImage& image,
                                        const Rigid3& cam_from_world) {
  if (!image.fiducials || !shared.world_given) return {};
  std::vector<PointObservation> corners = image.fiducials->corners;
  for (PointObservation& corner : corners) {
    const Eigen::Vector3d in_cam = cam_from_world * corner.point_in_world;
    corner.img = image.pyramid->Global(corner.img, &in_cam);
  }
  return corners;
}

std::vector<PointMatch> InliersOf(const std::vector<PointMatch>& matches, const PoseRefinement& refined) {
  std::vector<PointMatch> inliers;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (refined.inlier[i]) inliers.push_back(matches[i]);
  return inliers;
}

double MedianShiftPx(const CameraModel& camera, const FramePose& frame_pose, const Rigid3& cam_from_world) {
  std::vector<double> shifts;
  for (const PointMatch& match : frame_pose.matches) {
    if (const auto img = camera.ImgFromCam(cam_from_world * frame_pose.CandidateOf(match).position))
      shifts.push_back((*img - match.img).norm());
  }
  return shifts.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(shifts));
}

}  // namespace ulf::tracking
