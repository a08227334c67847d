// What the mapper does to make points: where a new keyframe sees what is known, what it makes new with its
// neighbours, and which of those are the same.
#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "core/base/quantile.h"
#include "core/geometry/triangulation.h"
#include "tracking/features/matching.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/mapper.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

constexpr int kPyramidsKept = 12;  // keyframes whose images are kept for alignment
constexpr double kChi2 = 5.99;     // 95 % in two dimensions

}  // namespace

int Mapper::Insert(NewKeyframe& offered) {
  const MapLock lock(shared_);
  Map& map = shared_.map;
  const int id = map.AddKeyframe(std::move(offered.keyframe));
  for (NewKeyframe::Seen& seen : offered.seen) {
    const int point = map.Resolve(seen.point);
    if (point < 0) continue;
    seen.observation.keyframe = id;
    // A point merged since was aligned with another patch.
    if (point != seen.point) seen.observation = Measure(map.point(point), id, seen.observation.feature);
    if (map.Observe(point, seen.observation)) map.Update(point);
  }
  map.keyframe(id).points_at_birth = map.keyframe(id).points;
  int kept = 0;
  for (auto k = map.living().rbegin(); k != map.living().rend(); ++k) {
    Keyframe& keyframe = map.keyframe(*k);
    if (!keyframe.pyramid || ++kept <= kPyramidsKept) continue;
    keyframe.pyramid.reset();
    keyframe.color.release();
  }
  return id;
}

// The feature's position, aligned with the point's patch where both are at hand.
double Mapper::MedianDepth(int keyframe_id) const {
  const Keyframe& keyframe = map_.keyframe(keyframe_id);
  std::vector<double> depths;
  for (const int point : keyframe.point_of_feature)
    if (point >= 0) depths.push_back((keyframe.cam_from_world * map_.point(point).position).z());
  return depths.empty() ? 1 : Median(std::move(depths));
}

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
  Map& map = shared_.map;
  const int id = map.AddPoint(position);
  map.Observe(id, reference);
  map.Observe(id, other);
  const Keyframe& by = map.keyframe(reference.keyframe);
  if (!by.color.empty()) {
    const int x = std::clamp(static_cast<int>(reference.img.x()), 0, by.color.cols - 1);
    const int y = std::clamp(static_cast<int>(reference.img.y()), 0, by.color.rows - 1);
    if (by.color.channels() == 3) {
      const auto& bgr = by.color.at<cv::Vec3b>(y, x);
      map.point(id).rgb = {bgr[2], bgr[1], bgr[0]};
    } else {
      map.point(id).rgb.fill(by.color.at<std::uint8_t>(y, x));
    }
  }
  map.SetPatch(id, reference);
  map.Update(id);
  // Measured against the patch, the reference is exact and the other view as exact as the alignment.
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
    if (baseline < 0.01 * MedianDepth(other_id)) continue;
    const Rigid3 other_from_this = other.cam_from_world * keyframe.cam_from_world.Inverse();
    const Vector3d epipole_direction = other_from_this.translation.normalized();
    std::vector<int> open;
    for (int j = 0; j < other_features.size(); ++j)
      if (other.point_of_feature[static_cast<std::size_t>(j)] < 0) open.push_back(j);

    for (int i = 0; i < features.size(); ++i) {
      if (keyframe.point_of_feature[static_cast<std::size_t>(i)] >= 0) continue;
      const Feature& feature = features[i];
      const Vector3d normal = epipole_direction.cross(other_from_this.rotation * feature.ray);
      const double length = normal.norm();
      if (length < 0.02) continue;  // on the epipole: the line is undefined
      const Vector3d plane = normal / length;
      int best = -1, best_distance = kSureDistance, second_distance = 256;
      for (const int j : open) {
        const Feature& candidate = other_features[j];
        if (std::abs(plane.dot(candidate.ray)) * focal > 2.0 * DetectedSigmaPx(candidate.level)) continue;
        const int distance = Distance(feature.descriptor, candidate.descriptor);
        if (distance < best_distance) {
          second_distance = best_distance;
          best_distance = distance;
          best = j;
        } else if (distance < second_distance) {
          second_distance = distance;
        }
      }
      if (best < 0 || best_distance > 0.9 * second_distance) continue;
      if (other.point_of_feature[static_cast<std::size_t>(best)] >= 0) continue;
      if (HasTwin(features, i, best_distance * 4 / 3)) continue;
      const Feature& match = other_features[best];
      const auto point =
          TriangulatePoint(keyframe.cam_from_world, feature.ray, other.cam_from_world, match.ray);
      if (!point || ParallaxAngle(*point, center, other_center) * 180 / M_PI < options_.min_parallax_deg)
        continue;
      const auto fits = [&](const Rigid3& pose, const Feature& seen) {
        const auto img = camera_.ImgFromCam(pose * *point);
        const double sigma = DetectedSigmaPx(seen.level);
        return img && (*img - seen.img).squaredNorm() < kChi2 * sigma * sigma;
      };
      if (!fits(keyframe.cam_from_world, feature) || !fits(other.cam_from_world, match)) continue;
      // Levels must tell the same story as distances.
      const double distance_ratio = (*point - other_center).norm() / (*point - center).norm();
      const double level_ratio = LevelScale(feature.level) / LevelScale(match.level);
      if (distance_ratio > 1.8 * level_ratio || level_ratio > 1.8 * distance_ratio) continue;
      const MapLock lock(shared_);
      CommitPoint(*point, {newest, i, feature.img, DetectedSigmaPx(feature.level)},
                  {other_id, best, match.img, DetectedSigmaPx(match.level)});
    }
  }
}

void Mapper::Fuse(int newest, const std::vector<int>& neighbours) {
  const auto points_of = [&](int keyframe) {
    std::vector<int> points;
    for (const int point : map_.keyframe(keyframe).point_of_feature)
      if (point >= 0) points.push_back(point);
    return points;
  };
  for (const int neighbour : neighbours) FuseInto(neighbour, points_of(newest));
  std::vector<int> theirs;
  for (const int neighbour : neighbours) {
    const std::vector<int> points = points_of(neighbour);
    theirs.insert(theirs.end(), points.begin(), points.end());
  }
  std::sort(theirs.begin(), theirs.end());
  theirs.erase(std::unique(theirs.begin(), theirs.end()), theirs.end());
  FuseInto(newest, theirs);
}

// Looks for points in a keyframe that does not know that it sees them.
void Mapper::FuseInto(int keyframe_id, const std::vector<int>& points) {
  const Keyframe& keyframe = map_.keyframe(keyframe_id);
  const Vector3d center = keyframe.cam_from_world.OriginInSource();
  constexpr double kRadiusPx = 3, kMinCosine = 0.5;
  for (const int id : points) {
    const MapPoint& point = map_.point(id);
    if (!point.alive) continue;
    if (std::any_of(point.observations.begin(), point.observations.end(),
                    [&](const Observation& o) { return o.keyframe == keyframe_id; }))
      continue;
    const Vector3d towards = point.position - center;
    const double distance = towards.norm();
    if (distance < point.nearest || distance > point.farthest ||
        towards.dot(point.mean_direction) < kMinCosine * distance)
      continue;
    const auto img = camera_.ImgFromCam(keyframe.cam_from_world * point.position);
    if (!img || !camera_.Contains(*img)) continue;
    const int level = std::clamp(static_cast<int>(std::lround(std::log(point.reference_distance / distance) /
                                                              std::log(kPyramidFactor))),
                                 0, kPyramidLevels - 1);
    int best = -1, best_distance = kSureDistance;
    keyframe.features->ForEachNear(*img, kRadiusPx * LevelScale(level), std::max(0, level - 1), level + 1,
                                   [&](int j) {
                                     const Feature& feature = (*keyframe.features)[j];
                                     const double sigma = DetectedSigmaPx(feature.level);
                                     if ((feature.img - *img).squaredNorm() > kChi2 * sigma * sigma) return;
                                     const int apart = Distance(point.descriptor, feature.descriptor);
                                     if (apart < best_distance) {
                                       best_distance = apart;
                                       best = j;
                                     }
                                   });
    if (best < 0) continue;
    const MapLock lock(shared_);
    Map& map = shared_.map;
    const int present = keyframe.point_of_feature[static_cast<std::size_t>(best)];
    if (present < 0) {
      map.Observe(id, Measure(point, keyframe_id, best));
      map.Update(id);
      continue;
    }
    const bool keep_present = map.point(present).observations.size() >= point.observations.size();
    const int kept = keep_present ? present : id, gone = keep_present ? id : present;
    std::unordered_set<int> before;
    for (const Observation& o : map.point(kept).observations) before.insert(o.keyframe);
    map.Merge(gone, kept);
    // What came over was measured against the other patch.
    for (Observation& o : map.point(kept).observations)
      if (!before.contains(o.keyframe)) o = Measure(map.point(kept), o.keyframe, o.feature);
    map.Update(kept);
  }
}

}  // namespace ulf::tracking
