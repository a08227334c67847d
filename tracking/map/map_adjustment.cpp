#include "tracking/map/map_adjustment.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/similarity3.h"
#include "core/geometry/small_matrices.h"
#include "tracking/map/map_rows.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// A given world holds the map where at least so many keyframes show at least so many corners, from centres
// that are spread by this share of their distance. Fewer leave the scale to chance. Guessed.
constexpr std::size_t kGivenWorldMinCorners = 4;
constexpr int kGivenWorldMinViews = 3;
constexpr double kGivenWorldMinSpread = 0.02;

// Returns the similarity that brings one set of camera poses nearest to another. Centres alone leave the turn
// about a straight path open, and say little where they are hardly apart. A move counts by the angle that it
// makes at the scene, as a turn does. `distance`: of the scene, in the units of `from`.
Similarity3 AlignPoses(const std::vector<Rigid3>& from, const std::vector<Rigid3>& to, double distance) {
  const double n = static_cast<double>(from.size());
  Vector3d from_mean = Vector3d::Zero(), to_mean = Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i].OriginInSource() / n;
    to_mean += to[i].OriginInSource() / n;
  }
  double from_spread = 0, to_spread = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_spread += (from[i].OriginInSource() - from_mean).squaredNorm() / n;
    to_spread += (to[i].OriginInSource() - to_mean).squaredNorm() / n;
  }
  if (!(from_spread > 0 && to_spread > 0 && distance > 0)) return {};
  Similarity3 to_from;
  to_from.scale = std::sqrt(to_spread / from_spread);
  Eigen::Matrix3d agreement = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    agreement += (to[i].OriginInSource() - to_mean) * (from[i].OriginInSource() - from_mean).transpose() /
                     (to_from.scale * distance * distance) +
                 to[i].RotationMatrix().transpose() * from[i].RotationMatrix();
  const SingularValues3 svd = SingularValuesOf(agreement);
  const double sign = (svd.u * svd.v.transpose()).determinant() < 0 ? -1 : 1;
  to_from.rotation = svd.u * Vector3d(1, 1, sign).asDiagonal() * svd.v.transpose();
  to_from.translation = to_mean - to_from.scale * (to_from.rotation * from_mean);
  return to_from;
}

// Images leave the world's origin, axes and unit open. With the first keyframe held all others would swing
// about it. Poses that users have kept fit the adjusted map best when the keyframes together stay where they
// were. A pinned pose leaves nothing open.
// Each part has a gauge of its own.
void KeepGauge(const Map& map, int part, const std::vector<int>& keyframes, const std::vector<int>& point_ids,
               BundleProblem& problem) {
  std::vector<Rigid3> before, after;
  std::vector<std::size_t> moved;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const Keyframe& keyframe = map.keyframe(keyframes[i]);
    if (keyframe.part != part) continue;
    if (keyframe.pinned) return;
    moved.push_back(i);
    before.push_back(keyframe.cam_from_world);
    after.push_back(problem.cam_from_world[i]);
  }
  const Vector3d middle = after.front().OriginInSource();
  std::vector<double> distances;
  for (std::size_t i = 0; i < point_ids.size(); ++i)
    if (map.point(point_ids[i]).part == part) distances.push_back((problem.points[i] - middle).norm());
  if (distances.empty()) return;
  const Similarity3 to_from = AlignPoses(after, before, Median(std::move(distances)));
  for (const std::size_t i : moved) {
    Rigid3& pose = problem.cam_from_world[i];
    const Vector3d center = to_from * pose.OriginInSource();
    pose.rotation = (pose.rotation * Eigen::Quaterniond(to_from.rotation).conjugate()).normalized();
    if (i < problem.rows.size() && problem.rows[i]) problem.rows[i]->twist.tail<3>() *= to_from.scale;
    pose.translation = -(pose.rotation * center);
  }
  for (std::size_t i = 0; i < point_ids.size(); ++i)
    if (map.point(point_ids[i]).part == part) problem.points[i] = to_from * problem.points[i];
}

void AddCorners(const Map& map, const std::unordered_map<int, int>& camera_index, BundleProblem& problem) {
  problem.known.assign(problem.points.size(), false);
  for (const auto& [id, index] : std::map<int, int>(camera_index.begin(), camera_index.end())) {
    if (problem.fixed[At(index)]) continue;
    const Keyframe& keyframe = map.keyframe(id);
    for (const PointObservation& corner : keyframe.corners) {
      const bool as_seen = problem.rows[At(index)] || !keyframe.rows;
      const Eigen::Vector2d img =
          as_seen ? corner.img
                  : keyframe.rows->Global(corner.img, keyframe.cam_from_world * corner.point_in_world);
      problem.observations.push_back(
          {index, static_cast<int>(problem.points.size()), img, corner.sigma_px, false});
      problem.points.push_back(corner.point_in_world);
      problem.known.push_back(true);
    }
  }
}

// Returns whether the corners that these keyframes saw determine the map's position, orientation and scale.
bool CornersHoldTheMap(const Map& map, const std::vector<int>& keyframes) {
  Vector3d mean = Vector3d::Zero();
  double squared = 0, distance = 0;
  int views = 0;
  for (const int id : keyframes) {
    const Keyframe& keyframe = map.keyframe(id);
    if (keyframe.corners.size() < kGivenWorldMinCorners) continue;
    const Vector3d center = keyframe.cam_from_world.OriginInSource();
    ++views;
    mean += center;
    squared += center.squaredNorm();
    distance += (keyframe.corners.front().point_in_world - center).norm();
  }
  if (views < kGivenWorldMinViews) return false;
  const double spread = squared / views - (mean / views).squaredNorm();
  return spread > std::pow(kGivenWorldMinSpread * distance / views, 2);
}

// Updates the points in pieces, so that the tracker does not wait for the lock for long.
void WriteBack(OwnedMap& owned, const std::unordered_map<int, int>& camera_index,
               const std::vector<int>& point_ids, const std::vector<std::pair<int, int>>& origin,
               const BundleProblem& problem) {
  std::vector<int> changed;  // points that lost observations
  {
    const MapLock lock(owned.shared);
    Map& map = owned.map;
    for (const auto& [id, index] : camera_index)
      map.keyframe(id).cam_from_world = problem.cam_from_world[At(index)];
    for (std::size_t i = 0; i < point_ids.size(); ++i) map.point(point_ids[i]).position = problem.points[i];
    for (std::size_t i = 0; i < origin.size(); ++i) {
      if (!problem.observations[i].outlier || !map.point(origin[i].first).alive) continue;
      map.RemoveObservation(origin[i].first, origin[i].second);
      changed.push_back(origin[i].first);
    }
  }
  constexpr std::size_t kAtOnce = 500;  // points in one hold of the lock: some tens of microseconds. Guessed
  for (std::size_t from = 0; from < point_ids.size(); from += kAtOnce) {
    const MapLock lock(owned.shared);
    for (std::size_t i = from; i < std::min(point_ids.size(), from + kAtOnce); ++i)
      owned.map.UpdateGeometry(point_ids[i]);
  }
  const MapLock lock(owned.shared);
  for (const int id : changed) owned.map.Update(id);
}

// Returns whether a keyframe turned so fast that the rows' velocity, taken from poses of a map that may have
// been bent, must be found with the map. In slower ones errors of the points would move it by more than it is
// off.
bool RowsAreUnsure(const Keyframe& keyframe) {
  constexpr double kLeastTurn = 0.01;  // during the readout, radians. Guessed
  return keyframe.rows && keyframe.expected_twist &&
         keyframe.expected_twist->head<3>().norm() * std::abs(keyframe.rows->readout_s()) > kLeastTurn;
}

RowsMotion RowsMotionOf(const Map& map, const Keyframe& keyframe) {
  // Radians and depths per second, and the share of the velocity. Chosen on drawn rooms
  // (docs/measured/tracking.md, "Rolling shutter"): with more freedom a map of little parallax drifts in
  // scale, with less it stays bent.
  constexpr double kTremorTurn = 0.01, kTremorShift = 0.003, kBent = 0.1;
  const Twist& expected = *keyframe.expected_twist;
  RowsMotion motion{keyframe.rows->twist(), expected, {}};
  const double turn = std::hypot(kTremorTurn, kBent * expected.head<3>().norm());
  const double shift =
      std::hypot(kTremorShift * map.MedianDepth(keyframe.id), kBent * expected.tail<3>().norm());
  motion.prior_sigma << Vector3d::Constant(turn), Vector3d::Constant(shift);
  return motion;
}

// Gives the keyframes the rows that the adjustment found.
void WriteRows(const CameraModel& camera, OwnedMap& owned, const std::vector<int>& keyframes,
               const std::vector<std::pair<int, int>>& origin, const BundleProblem& problem) {
  const Map& map = owned.shared.ReadByOwner();
  std::vector<std::vector<RowObservation>> seen_by(keyframes.size());
  for (std::size_t i = 0; i < origin.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    if (At(seen.camera) >= keyframes.size() || !problem.rows[At(seen.camera)] || seen.outlier) continue;
    const std::vector<Observation>& observations = map.point(origin[i].first).observations;
    const auto found = std::ranges::find_if(
        observations, [&](const Observation& o) { return o.keyframe == origin[i].second; });
    if (found == observations.end()) continue;
    seen_by[At(seen.camera)].push_back(
        {origin[i].first, static_cast<std::size_t>(found - observations.begin()),
         problem.cam_from_world[At(seen.camera)] * problem.points[At(seen.point)], seen.img});
  }
  for (std::size_t c = 0; c < keyframes.size(); ++c) {
    if (!problem.rows[c]) continue;
    auto rows = std::make_shared<const RowShift>(camera, problem.readout_s, problem.rows[c]->twist,
                                                 DepthsOf(camera, seen_by[c]));
    const MapLock lock(owned.shared);
    ReplaceRows(camera, owned.map, keyframes[c], seen_by[c], std::move(rows));
  }
}

// `lenses`: one, which changes where options.free says so.
BundleSummary AdjustMapUnder(std::vector<CameraModel>& lenses, OwnedMap& owned, const std::vector<int>& free,
                             const std::vector<int>& held, const BundleOptions& options, bool rows_too) {
  const Map& map = owned.shared.ReadByOwner();
  BundleProblem problem;
  std::unordered_map<int, int> camera_index, point_index;
  std::vector<int> point_ids;
  std::vector<std::pair<int, int>> origin;  // point id and keyframe of each observation
  const auto add_camera = [&](int id, bool fixed) {
    camera_index[id] = static_cast<int>(problem.cam_from_world.size());
    problem.cam_from_world.push_back(map.keyframe(id).cam_from_world);
    problem.fixed.push_back(fixed || map.keyframe(id).pinned);
    const Keyframe& keyframe = map.keyframe(id);
    const bool moves = rows_too && RowsAreUnsure(keyframe);
    if (moves) problem.readout_s = keyframe.rows->readout_s();
    problem.rows.push_back(moves ? std::optional(RowsMotionOf(map, keyframe)) : std::nullopt);
  };
  // The first keyframe of a part holds its world unless corners do.
  const bool world_given = owned.shared.world_given;
  const bool given = world_given && CornersHoldTheMap(map, free);
  for (const int id : free) add_camera(id, !given && id == map.FirstKeyframe(map.keyframe(id).part));
  for (const int id : held) add_camera(id, true);
  if (!given && std::find(problem.fixed.begin(), problem.fixed.end(), true) == problem.fixed.end())
    problem.fixed[0] = true;
  const std::vector<int>& owners = free.empty() ? held : free;
  for (const int keyframe : owners)
    for (const int id : map.PointsSeenBy(keyframe)) {
      if (point_index.contains(id)) continue;
      point_index[id] = static_cast<int>(point_ids.size());
      point_ids.push_back(id);
    }
  for (const int id : point_ids) {
    const MapPoint& point = map.point(id);
    problem.points.push_back(point.position);
    for (const Observation& o : point.observations) {
      const auto seen_by = camera_index.find(o.keyframe);
      if (seen_by == camera_index.end()) continue;
      const Keyframe& keyframe = map.keyframe(o.keyframe);
      const bool moves = problem.rows[At(seen_by->second)].has_value();
      const Eigen::Vector2d img =
          moves ? keyframe.rows->Seen(o.img, keyframe.cam_from_world * point.position) : o.img;
      problem.observations.push_back({seen_by->second, point_index[id], img, o.sigma_px, false});
      origin.emplace_back(id, o.keyframe);
    }
  }
  if (world_given) AddCorners(map, camera_index, problem);
  const BundleSummary summary = AdjustBundle(lenses, problem, options);
  spdlog::debug(
      "bundle: {} cameras ({} held), {} points, {} observations: {:.3f} -> {:.3f} sigmas, {} outliers",
      problem.cam_from_world.size(), held.size(), problem.points.size(), problem.observations.size(),
      summary.initial_rms_sigmas, summary.final_rms_sigmas, summary.outliers);
  if (!summary.usable) return summary;

  if (held.empty() && free.size() > 2 && !given) {
    std::set<int> parts;
    for (const int id : free) parts.insert(map.keyframe(id).part);
    for (const int part : parts) KeepGauge(map, part, free, point_ids, problem);
  }
  WriteBack(owned, camera_index, point_ids, origin, problem);
  if (problem.readout_s != 0) WriteRows(lenses[0], owned, free, origin, problem);
  return summary;
}

}  // namespace

BundleProblem ProblemOf(const Map& map) {
  BundleProblem problem;
  std::vector<int> index(map.keyframes().size(), -1);
  for (const Keyframe& keyframe : map.keyframes()) {
    if (!keyframe.alive) continue;
    index[At(keyframe.id)] = static_cast<int>(problem.cam_from_world.size());
    problem.cam_from_world.push_back(keyframe.cam_from_world);
  }
  for (const MapPoint& point : map.points()) {
    if (!point.alive) continue;
    for (const Observation& o : point.observations)
      problem.observations.push_back(
          {index[At(o.keyframe)], static_cast<int>(problem.points.size()), o.img, o.sigma_px, false});
    problem.points.push_back(point.position);
  }
  return problem;
}

BundleSummary AdjustMap(const CameraModel& camera, OwnedMap& owned, const std::vector<int>& free,
                        const std::vector<int>& held, const BundleOptions& options, bool rows_too) {
  std::vector<CameraModel> lenses{camera};
  return AdjustMapUnder(lenses, owned, free, held, options, rows_too);
}

BundleSummary AdjustMapAndLens(CameraModel& lens, OwnedMap& owned, const BundleOptions& options) {
  std::vector<CameraModel> lenses{lens};
  const BundleSummary summary =
      AdjustMapUnder(lenses, owned, owned.shared.ReadByOwner().living(), {}, options, false);
  if (summary.usable) lens = lenses[0];
  return summary;
}

}  // namespace ulf::tracking
