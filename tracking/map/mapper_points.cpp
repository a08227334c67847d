// The part of the mapper that makes points: inserts a keyframe, triangulates with its neighbours, and merges
// points that exist twice.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/at.h"
#include "core/geometry/angles.h"
#include "core/geometry/triangulation.h"
#include "tracking/features/matching.h"
#include "tracking/map/mapper.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// Between two views, of the depth; closer views tell no depth. Guessed
constexpr double kMapperMinBaseline = 0.01;
// Sine of the angle from the epipole: lines are undefined there. Guessed.
constexpr double kMapperMinEpipoleDistance = 0.02;
constexpr double kMapperEpipolarSigmas = 2;  // a match lies so close to its epipolar line. Guessed
constexpr double kMapperMaxRatio = 0.9;      // best descriptor distance / second best. Guessed
// A twin in the same image within this share of the best distance makes the match ambiguous. Guessed.
constexpr double kMapperTwinDistanceShare = 4.0 / 3;
// The ratio of distances may differ by this factor from the ratio of pyramid scales. Guessed
constexpr double kMapperMaxLevelMismatch = 1.8;
// Merging: a point is looked for within this radius (level pixels) in keyframes that see it from less than
// 60 degrees aside (as a cosine). Guessed.
constexpr double kMapperFuseRadiusPx = 3;
constexpr double kMapperFuseMinCosine = 0.5;
constexpr int kMapperPyramidsKept = 12;  // newest keyframes whose images are kept for alignment. Guessed

// Takes nearer descriptors only.
NearestDescriptor UnderSureDistance() { return {-1, kSureDistance, kSureDistance}; }

}  // namespace

int Mapper::Insert(NewKeyframe& offered) {
  const MapLock lock(owned_.shared);
  Map& map = owned_.map;
  const int id = map.AddKeyframe(std::move(offered.keyframe));
  for (NewKeyframe::Seen& seen : offered.seen) {
    const int point = map.Resolve(seen.point);
    if (point < 0) continue;
    seen.observation.keyframe = id;
    // A point that was merged meanwhile has another patch.
    if (point != seen.point) seen.observation = Measure(map.point(point), id, seen.observation.feature);
    if (map.AddObservation(point, seen.observation)) map.Update(point);
  }
  map.keyframe(id).points_at_birth = map.keyframe(id).points;
  int kept = 0;
  for (auto k = map.living().rbegin(); k != map.living().rend(); ++k) {
    Keyframe& keyframe = map.keyframe(*k);
    if (!keyframe.pyramid || ++kept <= kMapperPyramidsKept) continue;
    keyframe.pyramid.reset();
    keyframe.color.release();
  }
  return id;
}

// Returns the feature's position, aligned with the point's patch where both are at hand.
Observation Mapper::Measure(const MapPoint& point, int keyframe_id, int feature_index) const {
  const Keyframe& keyframe = map_.keyframe(keyframe_id);
  const Feature& feature = (*keyframe.features)[feature_index];
  Observation observation{keyframe_id, feature_index, feature.img, DetectedSigmaPx(feature.level)};
  if (!point.patch || !keyframe.pyramid) return observation;
  const auto aligned = AlignPatch(camera_, *point.patch, point.patch_axes, point.position,
                                  keyframe.cam_from_world, *keyframe.pyramid, feature.img);
  if (!aligned) return observation;
  observation.img = aligned->img;
  observation.sigma_px = AlignedSigmaPx(aligned->level);
  return observation;
}

void Mapper::CommitPoint(const Vector3d& position, const Observation& reference, const Observation& other) {
  Map& map = owned_.map;
  const int id = map.AddPoint(position, map.keyframe(reference.keyframe).part);
  map.AddObservation(id, reference);
  map.AddObservation(id, other);
  const Keyframe& by = map.keyframe(reference.keyframe);
  if (!by.color.empty()) map.point(id).rgb = RgbAt(by.color, reference.img);
  map.SetPatch(id, reference);
  map.Update(id);
  // The patch comes from the reference, whose observation is therefore exact; the other is aligned with it.
  if (MapPoint& made = map.point(id); made.patch) {
    if (by.pyramid->rows) {  // its own depth is known now
      const Vector3d in_cam = by.cam_from_world * made.position;
      made.observations[0].img = by.pyramid->Global(by.pyramid->Seen(reference.img), &in_cam);
    }
    made.observations[0].sigma_px = AlignedSigmaPx((*by.features)[reference.feature].level);
    made.observations[1] = Measure(made, other.keyframe, other.feature);
  }
  recent_points_.push_back(id);
}

void Mapper::Triangulate(int newest, const std::vector<int>& neighbours) {
  const Keyframe& keyframe = map_.keyframe(newest);
  const FeatureSet& features = *keyframe.features;
  const Vector3d center = keyframe.cam_from_world.OriginInSource();
  const double focal = camera_.MeanFocalPx();
  for (const int other_id : neighbours) {
    const Keyframe& other = map_.keyframe(other_id);
    const FeatureSet& other_features = *other.features;
    const Vector3d other_center = other.cam_from_world.OriginInSource();
    const double baseline = (other_center - center).norm();
    if (baseline < kMapperMinBaseline * map_.MedianDepth(other_id)) continue;
    const Rigid3 other_from_this = other.cam_from_world * keyframe.cam_from_world.Inverse();
    const Vector3d epipole_direction = other_from_this.translation.normalized();
    std::vector<int> open;
    for (int j = 0; j < other_features.size(); ++j)
      if (other.point_of_feature[At(j)] < 0) open.push_back(j);

    for (int i = 0; i < features.size(); ++i) {
      if (keyframe.point_of_feature[At(i)] >= 0) continue;
      const Feature& feature = features[i];
      const Vector3d normal = epipole_direction.cross(other_from_this.rotation * feature.ray);
      const double length = normal.norm();
      if (length < kMapperMinEpipoleDistance) continue;
      const Vector3d plane = normal / length;
      NearestDescriptor nearest = UnderSureDistance();
      for (const int j : open) {
        const Feature& candidate = other_features[j];
        if (std::abs(plane.dot(candidate.ray)) * focal >
            kMapperEpipolarSigmas * DetectedSigmaPx(candidate.level))
          continue;
        nearest.Offer(j, Distance(feature.descriptor, candidate.descriptor));
      }
      const int best = nearest.index;
      if (best < 0 || nearest.distance > kMapperMaxRatio * nearest.second) continue;
      if (other.point_of_feature[At(best)] >= 0) continue;
      if (IsRepetitive(features, i, static_cast<int>(kMapperTwinDistanceShare * nearest.distance))) continue;
      const Feature& match = other_features[best];
      const auto point =
          TriangulatePoint(keyframe.cam_from_world, feature.ray, other.cam_from_world, match.ray);
      if (!point || Degrees(ParallaxAngle(*point, center, other_center)) < options_.min_parallax_deg)
        continue;
      const auto fits = [&](const Rigid3& pose, const Feature& seen) {
        const auto img = camera_.ImgFromCam(pose * *point);
        const double sigma = DetectedSigmaPx(seen.level);
        return img && (*img - seen.img).squaredNorm() < kChi2 * sigma * sigma;
      };
      if (!fits(keyframe.cam_from_world, feature) || !fits(other.cam_from_world, match)) continue;
      // The pyramid levels must agree with the distances.
      const double distance_ratio = (*point - other_center).norm() / (*point - center).norm();
      const double level_ratio = LevelScale(feature.level) / LevelScale(match.level);
      const double mismatch = kMapperMaxLevelMismatch;
      if (distance_ratio > mismatch * level_ratio || level_ratio > mismatch * distance_ratio) continue;
      const MapLock lock(owned_.shared);
      CommitPoint(*point, {newest, i, feature.img, DetectedSigmaPx(feature.level)},
                  {other_id, best, match.img, DetectedSigmaPx(match.level)});
    }
  }
}

void Mapper::Fuse(int newest, const std::vector<int>& neighbours) {
  for (const int neighbour : neighbours) FuseInto(neighbour, map_.PointsSeenBy(newest));
  FuseInto(newest, map_.PointsSeenBy(neighbours));
}

// Finds points in a keyframe that does not observe them yet; merges them with points that it observes there.
void Mapper::FuseInto(int keyframe_id, const std::vector<int>& points) {
  const Keyframe& keyframe = map_.keyframe(keyframe_id);
  const Vector3d center = keyframe.cam_from_world.OriginInSource();
  for (const int id : points) {
    const MapPoint& point = map_.point(id);
    if (!point.alive) continue;
    if (std::ranges::any_of(point.observations,
                            [&](const Observation& o) { return o.keyframe == keyframe_id; }))
      continue;
    const Vector3d towards = point.position - center;
    const double distance = towards.norm();
    if (distance < point.nearest || distance > point.farthest ||
        towards.dot(point.mean_direction) < kMapperFuseMinCosine * distance)
      continue;
    const auto img = camera_.ImgFromCam(keyframe.cam_from_world * point.position);
    if (!img || !camera_.Contains(*img)) continue;
    const int level = NearestLevel(point.reference_distance / distance);
    NearestDescriptor nearest = UnderSureDistance();
    keyframe.features->ForEachNear(*img, kMapperFuseRadiusPx * LevelScale(level), std::max(0, level - 1),
                                   level + 1, [&](int j) {
                                     const Feature& feature = (*keyframe.features)[j];
                                     const double sigma = DetectedSigmaPx(feature.level);
                                     if ((feature.img - *img).squaredNorm() <= kChi2 * sigma * sigma)
                                       nearest.Offer(j, Distance(point.descriptor, feature.descriptor));
                                   });
    if (nearest.index < 0) continue;
    const MapLock lock(owned_.shared);
    Map& map = owned_.map;
    const int present = keyframe.point_of_feature[At(nearest.index)];
    if (present < 0) {
      map.AddObservation(id, Measure(point, keyframe_id, nearest.index));
      map.Update(id);
      continue;
    }
    const bool keep_present = map.point(present).observations.size() >= point.observations.size();
    const int kept = keep_present ? present : id, gone = keep_present ? id : present;
    // The moved observations were measured against the other patch.
    for (Observation& o : map.Merge(gone, kept)) o = Measure(map.point(kept), o.keyframe, o.feature);
    map.Update(kept);
  }
}

}  // namespace ulf::tracking
