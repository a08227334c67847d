#include "tracking/mapper.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "tracking/loop_closer.h"
#include "tracking/map_adjustment.h"
#include "tracking/map_matching.h"
#include "tracking/matching.h"
#include "tracking/quantile.h"
#include "tracking/triangulation.h"

namespace ulf {
namespace {

using Eigen::Vector3d;

constexpr int kPyramidsKept = 12;    // keyframes whose images are kept for alignment
constexpr int kTriangulateWith = 8;  // neighbours
constexpr int kFuseWith = 12;
constexpr int kLocalKeyframes = 14;
constexpr int kHeldKeyframes = 20;
constexpr double kChi2 = 5.99;  // 95 % in two dimensions
constexpr double kMinParallaxDeg = 1.0;

double MedianDepth(const Map& map, const Keyframe& keyframe) {
  std::vector<double> depths;
  for (const int point : keyframe.point_of_feature)
    if (point >= 0) depths.push_back((keyframe.cam_from_world * map.point(point).position).z());
  return depths.empty() ? 1 : Median(std::move(depths));
}

}  // namespace

Mapper::Mapper(const CameraModel& camera, SharedMap& shared, KeyframeIndex& index, bool synchronous,
               unsigned seed)
    : camera_(camera),
      shared_(shared),
      map_(shared.map),
      index_(index),
      synchronous_(synchronous),
      loops_(std::make_unique<LoopCloser>(camera, shared, index, LoopOptions{.seed = seed})) {
  if (!synchronous_) thread_ = std::thread([this] { Run(); });
}

Mapper::~Mapper() {
  {
    const std::lock_guard lock(work_mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool Mapper::Offer(NewKeyframe keyframe) {
  if (synchronous_) {
    Process(keyframe);
    return true;
  }
  {
    const std::lock_guard lock(work_mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    if (next_ || working_) return false;
    next_ = std::move(keyframe);
  }
  changed_.notify_all();
  return true;
}

void Mapper::Drain() {
  std::unique_lock lock(work_mutex_);
  changed_.wait(lock, [&] { return !next_ && !working_; });
}

void Mapper::Run() {
  std::unique_lock lock(work_mutex_);
  while (true) {
    changed_.wait(lock, [&] { return ending_ || next_; });
    if (ending_) return;
    NewKeyframe keyframe = std::move(*next_);
    next_.reset();
    working_ = true;
    lock.unlock();
    std::exception_ptr failure;
    try {
      Process(keyframe);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure) failure_ = failure;
    working_ = false;
    changed_.notify_all();
  }
}

void Mapper::Process(NewKeyframe& offered) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const int newest = Insert(offered);
  CullRecentPoints(newest);
  Triangulate(newest, Neighbours(newest, kTriangulateWith));
  const auto triangulated = Clock::now();
  Fuse(newest, Neighbours(newest, kFuseWith));
  const auto fused = Clock::now();
  AdjustLocal(newest, true);
  const auto adjusted = Clock::now();
  CullKeyframes(newest);
  if (const auto loop = loops_->Examine(newest)) {
    for (const int recent : loop->recent) Fuse(recent, loop->old);
    AdjustAll();
    ++shared_.revision;
  }
  index_.Add(map_.keyframe(newest));
  const auto ms = [](auto from, auto to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  };
  spdlog::debug("keyframe {}: {:.1f} ms to triangulate, {:.1f} to merge, {:.1f} to adjust, {:.1f} to clean",
                newest, ms(start, triangulated), ms(triangulated, fused), ms(fused, adjusted),
                ms(adjusted, Clock::now()));
}

void Mapper::StartFromTwoViews(const TwoViewStart& start, double scale, const cv::Mat& color) {
  const auto keyframe_of = [](const TrackedImage& image, const Rigid3& pose) {
    Keyframe keyframe;
    keyframe.time_s = image.time_s;
    keyframe.features = image.features;
    keyframe.pyramid = image.pyramid;
    keyframe.cam_from_world = pose;
    return keyframe;
  };
  int first, second;
  {
    const std::lock_guard lock(shared_.mutex);
    first = map_.AddKeyframe(keyframe_of(start.first, Rigid3{}));
    Rigid3 second_from_first = start.second_from_first;
    second_from_first.translation *= scale;
    second = map_.AddKeyframe(keyframe_of(start.second, second_from_first));
    map_.keyframe(second).color = color;
    for (std::size_t i = 0; i < start.matches.size(); ++i) {
      const FeatureMatch& match = start.matches[i];
      const Feature &a = (*start.first.features)[match.first], &b = (*start.second.features)[match.second];
      CommitPoint(scale * start.points[i], {second, match.second, b.img, DetectedSigmaPx(b.level)},
                  {first, match.first, a.img, DetectedSigmaPx(a.level)});
    }
  }
  AdjustMap(camera_, shared_, {first, second}, {}, {.robust_iterations = 15, .iterations = 15});
  // Adjustment changes depths: normalise again so that the median is one.
  const double again = 1 / MedianDepth(map_, map_.keyframe(first));
  {
    const std::lock_guard lock(shared_.mutex);
    map_.keyframe(second).cam_from_world.translation *= again;
    for (const int point : std::vector<int>(map_.keyframe(first).point_of_feature)) {
      if (point < 0) continue;
      map_.point(point).position *= again;
      map_.Update(point);
    }
  }
  for (const int keyframe : {first, second}) {
    const std::lock_guard lock(shared_.mutex);
    map_.keyframe(keyframe).points_at_birth = map_.keyframe(keyframe).points;
  }
  index_.Add(map_.keyframe(first));
  index_.Add(map_.keyframe(second));
}

void Mapper::AddSeed(NewKeyframe keyframe) {
  keyframe.keyframe.pinned = true;
  const int newest = Insert(keyframe);
  const std::vector<int> neighbours = NeighboursByPose(newest, kTriangulateWith);
  Triangulate(newest, neighbours);
  Fuse(newest, neighbours);
  AdjustLocal(newest, false);
  index_.Add(map_.keyframe(newest));
}

void Mapper::Reset() {
  const std::lock_guard lock(shared_.mutex);
  map_.Clear();
  index_.Clear();
  recent_points_.clear();
  loops_->Reset();
}

int Mapper::Insert(NewKeyframe& offered) {
  const std::lock_guard lock(shared_.mutex);
  const int id = map_.AddKeyframe(std::move(offered.keyframe));
  for (NewKeyframe::Seen& seen : offered.seen) {
    const int point = map_.Resolve(seen.point);
    if (point < 0) continue;
    seen.observation.keyframe = id;
    // A point merged since was aligned with another patch.
    if (point != seen.point) seen.observation = Measure(map_.point(point), id, seen.observation.feature);
    if (map_.Observe(point, seen.observation)) map_.Update(point);
  }
  map_.keyframe(id).points_at_birth = map_.keyframe(id).points;
  int kept = 0;
  for (int k = id; k >= 0; --k) {
    Keyframe& keyframe = map_.keyframe(k);
    if (!keyframe.pyramid || ++kept <= kPyramidsKept) continue;
    keyframe.pyramid.reset();
    keyframe.color.release();
  }
  return id;
}

// The feature's position, aligned with the point's patch where both are at hand.
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

std::vector<int> Mapper::Neighbours(int keyframe, int most) const {
  std::vector<int> chosen;
  for (const Map::Neighbour& neighbour : map_.Covisible(keyframe, 12)) {
    if (static_cast<int>(chosen.size()) >= most) break;
    chosen.push_back(neighbour.keyframe);
  }
  return chosen;
}

std::vector<int> Mapper::NeighboursByPose(int id, int most) const {
  const Rigid3& pose = map_.keyframe(id).cam_from_world;
  std::vector<std::pair<double, int>> ranked;
  for (const Keyframe& other : map_.keyframes()) {
    if (!other.alive || other.id == id) continue;
    const double cosine = other.cam_from_world.DirectionInSource(Vector3d::UnitZ())
                              .dot(pose.DirectionInSource(Vector3d::UnitZ()));
    if (cosine < 0.5) continue;
    ranked.emplace_back((other.cam_from_world.OriginInSource() - pose.OriginInSource()).norm(), other.id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> chosen;
  for (const auto& [distance, keyframe] : ranked)
    if (static_cast<int>(chosen.size()) < most) chosen.push_back(keyframe);
  return chosen;
}

void Mapper::CullRecentPoints(int newest) {
  const std::lock_guard lock(shared_.mutex);
  std::erase_if(recent_points_, [&](int id) {
    const MapPoint& point = map_.point(id);
    if (!point.alive) return true;
    const int age = newest - point.first_keyframe;
    const bool seldom_found = point.expected >= 8 && point.found < 0.25 * point.expected;
    const bool never_confirmed = age >= 3 && point.observations.size() <= 2;
    if (seldom_found || never_confirmed) {
      map_.RemovePoint(id);
      return true;
    }
    return age >= 4;
  });
}

void Mapper::CommitPoint(const Vector3d& position, const Observation& reference, const Observation& other) {
  const int id = map_.AddPoint(position);
  map_.Observe(id, reference);
  map_.Observe(id, other);
  const Keyframe& by = map_.keyframe(reference.keyframe);
  if (!by.color.empty()) {
    const int x = std::clamp(static_cast<int>(reference.img.x()), 0, by.color.cols - 1);
    const int y = std::clamp(static_cast<int>(reference.img.y()), 0, by.color.rows - 1);
    if (by.color.channels() == 3) {
      const auto& bgr = by.color.at<cv::Vec3b>(y, x);
      map_.point(id).rgb = {bgr[2], bgr[1], bgr[0]};
    } else {
      map_.point(id).rgb.fill(by.color.at<std::uint8_t>(y, x));
    }
  }
  map_.SetPatch(id, reference);
  map_.Update(id);
  // Measured against the patch, the reference is exact and the other view as exact as the alignment.
  if (map_.point(id).patch) {
    MapPoint& made = map_.point(id);
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
    if (baseline < 0.01 * MedianDepth(map_, other)) continue;
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
      if (!point || ParallaxAngle(*point, center, other_center) * 180 / M_PI < kMinParallaxDeg) continue;
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
      const std::lock_guard lock(shared_.mutex);
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
    const std::lock_guard lock(shared_.mutex);
    const int present = keyframe.point_of_feature[static_cast<std::size_t>(best)];
    if (present < 0) {
      map_.Observe(id, Measure(point, keyframe_id, best));
      map_.Update(id);
      continue;
    }
    const bool keep_present = map_.point(present).observations.size() >= point.observations.size();
    const int kept = keep_present ? present : id, gone = keep_present ? id : present;
    std::unordered_set<int> before;
    for (const Observation& o : map_.point(kept).observations) before.insert(o.keyframe);
    map_.Merge(gone, kept);
    // What came over was measured against the other patch.
    for (Observation& o : map_.point(kept).observations)
      if (!before.contains(o.keyframe)) o = Measure(map_.point(kept), o.keyframe, o.feature);
    map_.Update(kept);
  }
}

void Mapper::AdjustLocal(int newest, bool poses_too) {
  std::vector<int> local{newest};
  for (const int neighbour : Neighbours(newest, kLocalKeyframes - 1)) local.push_back(neighbour);
  std::unordered_map<int, int> shares;
  const std::unordered_set<int> in_local(local.begin(), local.end());
  std::unordered_set<int> visited;
  for (const int keyframe : local)
    for (const int point : map_.keyframe(keyframe).point_of_feature) {
      if (point < 0 || !visited.insert(point).second) continue;
      for (const Observation& o : map_.point(point).observations)
        if (!in_local.contains(o.keyframe)) ++shares[o.keyframe];
    }
  std::vector<std::pair<int, int>> ranked;
  for (const auto& [keyframe, count] : shares) ranked.emplace_back(-count, keyframe);
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> held;
  for (const auto& [count, keyframe] : ranked)
    if (static_cast<int>(held.size()) < kHeldKeyframes) held.push_back(keyframe);
  if (!poses_too) {
    held.insert(held.end(), local.begin(), local.end());
    local.clear();
  }
  AdjustMap(camera_, shared_, local, held, {.robust_iterations = 4, .iterations = 6, .stop = &ending_});
}

void Mapper::AdjustAll() {
  std::vector<int> all;
  for (const Keyframe& keyframe : map_.keyframes())
    if (keyframe.alive) all.push_back(keyframe.id);
  if (all.size() >= 2) AdjustMap(camera_, shared_, all, {}, {.robust_iterations = 10, .iterations = 40});
}

// A keyframe is superfluous when nine tenths of its points are seen as well by three others.
void Mapper::CullKeyframes(int newest) {
  for (const int id : Neighbours(newest, kLocalKeyframes)) {
    const Keyframe& keyframe = map_.keyframe(id);
    if (id == map_.FirstKeyframe() || id >= newest - 2 || keyframe.pinned) continue;
    int total = 0, redundant = 0;
    for (int i = 0; i < keyframe.features->size(); ++i) {
      const int point = keyframe.point_of_feature[static_cast<std::size_t>(i)];
      if (point < 0) continue;
      ++total;
      const int level = (*keyframe.features)[i].level;
      int others = 0;
      for (const Observation& o : map_.point(point).observations)
        if (o.keyframe != id && (*map_.keyframe(o.keyframe).features)[o.feature].level <= level + 1) ++others;
      redundant += others >= 3;
    }
    if (redundant <= 0.9 * total) continue;
    index_.Remove(id);
    const std::lock_guard lock(shared_.mutex);
    map_.RemoveKeyframe(id);
  }
}

}  // namespace ulf
