#include "tracking/map/loop_closer.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/base/quantile.h"
#include "tracking/estimation/pose_graph.h"
#include "tracking/estimation/pose_log_odds.h"
#include "tracking/estimation/sampling.h"
#include "tracking/features/matching.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The same point as two keyframes know it: each in its camera's frame, and where it was seen.
struct PointPair {
  Vector3d in_recent, in_old;
  Vector2d img_in_recent, img_in_old;
  double recent_sigma_px, old_sigma_px;
};

double ErrorSigmas2(const CameraModel& camera, const Vector3d& in_cam, const Vector2d& img, double sigma_px) {
  const auto projected = camera.ImgFromCam(in_cam);
  return projected ? (*projected - img).squaredNorm() / (sigma_px * sigma_px) : 1e9;
}

std::optional<Similarity3> SampleSimilarity(const CameraModel& camera, const std::vector<PointPair>& pairs,
                                            bool rigid, unsigned seed, int min_inliers) {
  struct Model {
    Similarity3 old_from_recent, recent_from_old;
  };
  const auto fit = [&](const std::vector<int>& chosen) -> std::optional<Model> {
    std::vector<Vector3d> recent, old;
    for (const int i : chosen) {
      recent.push_back(pairs[static_cast<std::size_t>(i)].in_recent);
      old.push_back(pairs[static_cast<std::size_t>(i)].in_old);
    }
    const auto similarity = AlignPoints(recent, old, rigid);
    if (!similarity || !(similarity->scale > 0)) return std::nullopt;
    return Model{*similarity, similarity->Inverse()};
  };
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<Model> models;
    if (const auto model = fit(sample)) models.push_back(*model);
    return models;
  };
  const auto residual2 = [&](const Model& model, int i) {
    const PointPair& pair = pairs[static_cast<std::size_t>(i)];
    return std::max(
        ErrorSigmas2(camera, model.old_from_recent * pair.in_recent, pair.img_in_old, pair.old_sigma_px),
        ErrorSigmas2(camera, model.recent_from_old * pair.in_old, pair.img_in_recent, pair.recent_sigma_px));
  };
  const auto improve = [&](const Model&, const std::vector<int>& inliers) { return fit(inliers); };
  const auto found = SampleConsensus<Model>(static_cast<int>(pairs.size()), 3, solve, residual2, improve,
                                            {.threshold = 4, .max_iterations = 300, .seed = seed});
  if (!found || static_cast<int>(found->inliers.size()) < min_inliers) return std::nullopt;
  return found->model.recent_from_old;
}

// All that is measured in the keyframe's unit but its pose.
void Scale(double scale, Keyframe& keyframe) {
  keyframe.unit *= scale;
  if (!keyframe.alive) keyframe.cam_from_parent.translation *= scale;
  if (keyframe.velocity) keyframe.velocity->tail<3>() *= scale;
  if (!keyframe.rows) return;
  keyframe.rows = std::make_shared<const RowShift>(keyframe.rows->Scaled(scale));
  if (keyframe.pyramid) keyframe.pyramid = WithRows(*keyframe.pyramid, keyframe.rows);
}

bool ScaleIsGiven(const SharedMap& shared) {
  const Map& map = shared.ReadByOwner();
  int pinned = 0;
  for (const int id : map.living())
    pinned += map.keyframe(id).pinned || (shared.world_given && !map.keyframe(id).corners.empty());
  return pinned >= 2;
}

double MedianDepth(const Map& map, const Keyframe& keyframe) {
  std::vector<double> depths;
  for (const int point : keyframe.point_of_feature)
    if (point >= 0) depths.push_back((keyframe.cam_from_world * map.point(point).position).z());
  return depths.empty() ? 1 : Median(std::move(depths));
}

// A keyframe and those that see most of the same.
std::vector<int> Neighbourhood(const Map& map, int keyframe, std::size_t most) {
  std::vector<int> around{keyframe};
  for (const Map::Neighbour& neighbour : map.Covisible(keyframe))
    if (around.size() < most) around.push_back(neighbour.keyframe);
  return around;
}

std::set<int> AllPointsOf(const Map& map, const std::vector<int>& keyframes) {
  std::set<int> points;
  for (const int keyframe : keyframes)
    for (const int point : map.keyframe(keyframe).point_of_feature)
      if (point >= 0) points.insert(point);
  return points;
}

constexpr std::size_t kAround = 12;

}  // namespace

LoopCloser::LoopCloser(const CameraModel& camera, SharedMap& shared, const KeyframeIndex& index,
                       const LoopOptions& options)
    : camera_(camera),
      shared_(shared),
      map_(shared.ReadByOwner()),
      index_(index),
      options_(options),
      locator_(camera, shared, 200) {}

void LoopCloser::Reset() {
  pending_.clear();
  last_closed_ = -1;
}

// What looks alike and is not tied to this keyframe's surroundings; each from another place.
std::vector<int> LoopCloser::Candidates(int newest) const {
  constexpr int kRanked = 30;
  constexpr std::size_t kMost = 3;
  std::set<int> taken{newest};
  const auto take_with_neighbours = [&](int keyframe) {
    taken.insert(keyframe);
    for (const Map::Neighbour& neighbour : map_.Covisible(keyframe)) taken.insert(neighbour.keyframe);
  };
  for (const Map::Neighbour& neighbour : map_.Covisible(newest)) take_with_neighbours(neighbour.keyframe);
  std::vector<int> candidates;
  for (const auto& [keyframe, votes] : index_.Query(*map_.keyframe(newest).features, kRanked)) {
    if (candidates.size() >= kMost) break;
    if (!map_.keyframe(keyframe).alive || taken.contains(keyframe)) continue;
    candidates.push_back(keyframe);
    take_with_neighbours(keyframe);
  }
  return candidates;
}

std::optional<LoopHypothesis> LoopCloser::Verify(int recent_id, int old_id) const {
  constexpr int kMinMatches = 20, kMinSampled = 15, kMinScalePairs = 15;
  constexpr double kMaxScaleSpread = 0.1;
  const Keyframe &recent = map_.keyframe(recent_id), &old = map_.keyframe(old_id);
  const bool rigid = ScaleIsGiven(shared_);
  const auto with_points = [](const Keyframe& keyframe) {
    std::vector<int> features;
    for (int i = 0; i < keyframe.features->size(); ++i)
      if (keyframe.point_of_feature[static_cast<std::size_t>(i)] >= 0) features.push_back(i);
    return features;
  };
  const auto position = [&](const Keyframe& keyframe, int feature) {
    const int point = keyframe.point_of_feature[static_cast<std::size_t>(feature)];
    return Vector3d(keyframe.cam_from_world * map_.point(point).position);
  };
  const auto matches = MatchAll(*recent.features, with_points(recent), *old.features, with_points(old),
                                {.max_distance = 70, .max_ratio = 0.85, .same_rotation = true});
  if (static_cast<int>(matches.size()) < kMinMatches) return std::nullopt;
  std::vector<PointPair> pairs;
  for (const FeatureMatch& match : matches) {
    const Feature &a = (*recent.features)[match.first], &b = (*old.features)[match.second];
    pairs.push_back({position(recent, match.first), position(old, match.second), a.img, b.img,
                     DetectedSigmaPx(a.level), DetectedSigmaPx(b.level)});
  }
  const auto sampled =
      SampleSimilarity(camera_, pairs, rigid, options_.seed + static_cast<unsigned>(recent_id), kMinSampled);
  if (!sampled) return std::nullopt;

  // The recent camera in the old part's world, against all that the old part knows.
  FramePose located;
  located.cam_from_world = (*sampled * Similarity3::FromRigid(old.cam_from_world)).WithoutScale();
  located.candidates = GatherCandidates(map_, camera_, located.cam_from_world);
  const std::set<int> known = AllPointsOf(map_, Neighbourhood(map_, old_id, kAround));
  const std::set<int> own = AllPointsOf(map_, Neighbourhood(map_, recent_id, kAround));
  std::erase_if(located.candidates,
                [&](const Candidate& c) { return !known.contains(c.id) || own.contains(c.id); });
  const TrackedImage image{recent.time_s, recent.pyramid, recent.features};
  const double unit = camera_.width / 640.0;
  StageTimes ignored;
  std::optional<FramePose> found = locator_.Refine(image, std::move(located), 10 * unit, ignored);
  if (found) found = locator_.Refine(image, std::move(*found), 4 * unit, ignored);
  if (!found || static_cast<int>(found->matches.size()) < options_.min_points ||
      PoseLogOdds(camera_, *found) <= kRelocalizedLogOdds) {
    spdlog::debug("loop {} to {}: {} matches, {} of {:.0f} points: not sure", recent_id, old_id,
                  matches.size(), found ? found->matches.size() : 0, found ? found->expected : 0.0);
    return std::nullopt;
  }

  LoopHypothesis hypothesis;
  std::vector<double> log_scales;
  for (const PointMatch& match : found->matches) {
    if (match.feature < 0) continue;
    const int point = recent.point_of_feature[static_cast<std::size_t>(match.feature)];
    if (point < 0) continue;
    const Candidate& candidate = found->candidates[static_cast<std::size_t>(match.candidate)];
    hypothesis.same.emplace_back(point, candidate.id);
    log_scales.push_back(std::log((recent.cam_from_world * map_.point(point).position).norm() /
                                  (found->cam_from_world * candidate.position).norm()));
  }
  if (static_cast<int>(log_scales.size()) < kMinScalePairs) return std::nullopt;
  const double log_scale = Median(log_scales);
  for (double& value : log_scales) value = std::abs(value - log_scale);
  if (Median(log_scales) > kMaxScaleSpread) return std::nullopt;
  hypothesis.recent = recent_id;
  hypothesis.old = old_id;
  hypothesis.points = static_cast<int>(found->matches.size());
  Similarity3 recent_from_world = Similarity3::FromRigid(found->cam_from_world);
  if (rigid) {
    if (std::abs(log_scale) > kMaxScaleSpread) return std::nullopt;
  } else {
    recent_from_world.scale = std::exp(log_scale);
    recent_from_world.translation *= recent_from_world.scale;
  }
  hypothesis.recent_from_old = recent_from_world * Similarity3::FromRigid(old.cam_from_world).Inverse();
  spdlog::debug("loop {} to {}: {} of {:.0f} points, scale {:.4f}", recent_id, old_id, hypothesis.points,
                found->expected, recent_from_world.scale);
  return hypothesis;
}

// Of the world about the recent camera: where the old part says that it is.
Similarity3 LoopCloser::Correction(const LoopHypothesis& hypothesis) const {
  const auto pose = [&](int keyframe) { return Similarity3::FromRigid(map_.PoseOf(keyframe)); };
  return pose(hypothesis.old).Inverse() * hypothesis.recent_from_old.Inverse() * pose(hypothesis.recent);
}

bool LoopCloser::Plausible(const LoopHypothesis& hypothesis) const {
  const Similarity3 correction = Correction(hypothesis);
  const auto [first, last] = std::minmax(hypothesis.recent, hypothesis.old);
  double way = 0;
  std::optional<Vector3d> before;
  for (int k = first; k <= last; ++k) {
    const Vector3d center = map_.PoseOf(k).OriginInSource();
    if (before) way += (center - *before).norm();
    before = center;
  }
  const Vector3d center = map_.PoseOf(hypothesis.recent).OriginInSource();
  const double moved = (correction * center - center).norm();
  const double turned_deg = Eigen::AngleAxisd(correction.rotation).angle() * 180 / M_PI;
  const bool plausible = moved <= options_.max_drift * way && turned_deg <= options_.max_turn_deg &&
                         std::abs(std::log(correction.scale)) <= std::log(options_.max_scale_change);
  if (!plausible)
    spdlog::debug("loop {} to {}: not drift: {:.3f} over a way of {:.3f}, {:.1f} degrees, scale {:.3f}",
                  hypothesis.recent, hypothesis.old, moved, way, turned_deg, correction.scale);
  return plausible;
}

bool LoopCloser::Agree(const LoopHypothesis& a, const LoopHypothesis& b) const {
  constexpr double kTolerance = 0.05;  // of the depth
  const Similarity3 by_a = Correction(a), by_b = Correction(b);
  const Keyframe& keyframe = map_.keyframe(a.recent);
  const Vector3d center = keyframe.cam_from_world.OriginInSource();
  std::vector<double> apart;
  for (const int point : keyframe.point_of_feature)
    if (point >= 0) {
      const Vector3d& position = map_.point(point).position;
      apart.push_back((by_a * position - by_b * position).norm() / (by_a.scale * (position - center).norm()));
    }
  return !apart.empty() && Median(std::move(apart)) < kTolerance;
}

std::optional<ClosedLoop> LoopCloser::Examine(int newest) {
  constexpr int kRest = 5;    // keyframes after a loop was closed
  constexpr int kMemory = 8;  // keyframes
  if (last_closed_ >= 0 && newest < last_closed_ + kRest) return std::nullopt;
  std::erase_if(pending_, [&](const LoopHypothesis& h) {
    return h.recent < newest - kMemory || !map_.keyframe(h.recent).alive || !map_.keyframe(h.old).alive;
  });
  std::vector<LoopHypothesis> verified;
  for (const int candidate : Candidates(newest))
    if (auto hypothesis = Verify(newest, candidate); hypothesis && Plausible(*hypothesis))
      verified.push_back(std::move(*hypothesis));
  if (verified.empty()) return std::nullopt;
  // Two places that both look like this one: neither is believed, nor what earlier keyframes said.
  for (const LoopHypothesis& other : verified)
    if (!Agree(verified.front(), other)) {
      spdlog::debug("loop {}: {} and {} contradict each other", newest, verified.front().old, other.old);
      pending_.clear();
      return std::nullopt;
    }
  std::erase_if(pending_, [&](const LoopHypothesis& h) { return !Agree(verified.front(), h); });
  pending_.push_back(verified.front());
  if (static_cast<int>(pending_.size()) < options_.agreeing) return std::nullopt;
  auto closed = Close(std::exchange(pending_, {}));
  if (closed) last_closed_ = newest;
  return closed;
}

std::optional<ClosedLoop> LoopCloser::Close(const std::vector<LoopHypothesis>& agreeing) {
  constexpr int kStrong = 60;   // shared points
  constexpr int kLongAgo = 20;  // keyframes: such a tie is an earlier loop's
  PoseGraph graph;
  std::map<int, int> node_of;
  std::vector<int> keyframes;
  for (const Keyframe& keyframe : map_.keyframes()) {
    if (!keyframe.alive) continue;
    node_of[keyframe.id] = static_cast<int>(keyframes.size());
    keyframes.push_back(keyframe.id);
    graph.cam_from_world.push_back(Similarity3::FromRigid(keyframe.cam_from_world));
    graph.fixed.push_back(keyframe.pinned || keyframe.id == map_.FirstKeyframe());
  }
  const auto add_edge = [&](int from, int to, double weight) {
    const std::size_t a = static_cast<std::size_t>(node_of.at(from)),
                      b = static_cast<std::size_t>(node_of.at(to));
    graph.edges.push_back({static_cast<int>(a), static_cast<int>(b),
                           graph.cam_from_world[b] * graph.cam_from_world[a].Inverse(), weight});
  };
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    bool tied = false;  // to an earlier one: the strongest such edge spans the graph
    for (const Map::Neighbour& neighbour : map_.Covisible(keyframes[i])) {
      const int apart = keyframes[i] - neighbour.keyframe;
      if (apart < 0 || (tied && neighbour.shared < kStrong && apart < kLongAgo)) continue;
      add_edge(neighbour.keyframe, keyframes[i], neighbour.shared / 100.0);
      tied = true;
    }
    constexpr double kLooseTie = 0.1;
    if (!tied) add_edge(keyframes[i - 1], keyframes[i], kLooseTie);
  }
  // A loop is measured as exactly as one step of the way is: next to the drift of all steps it holds. It must
  // not yield to the way's many parallel ties either, which say the same thing many times.
  constexpr double kHolds = 100;
  for (const LoopHypothesis& loop : agreeing)
    graph.edges.push_back(
        {node_of.at(loop.old), node_of.at(loop.recent), loop.recent_from_old, kHolds * loop.points / 100});
  const PoseGraphSummary solved = OptimizePoseGraph(
      graph,
      {.rigid = ScaleIsGiven(shared_), .unit = MedianDepth(map_, map_.keyframe(agreeing.back().recent))});
  spdlog::debug("loop {} to {} closed: pose graph of {} keyframes and {} edges, cost {:.4g} -> {:.4g}",
                agreeing.back().recent, agreeing.back().old, keyframes.size(), graph.edges.size(),
                solved.initial_cost, solved.final_cost);
  if (!solved.usable) return std::nullopt;

  ClosedLoop closed;
  const MapLock lock(shared_);
  std::vector<std::pair<int, Similarity3>> moved;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    moved.emplace_back(keyframes[i], graph.cam_from_world[i]);
  closed.recent = Neighbourhood(map_, agreeing.back().recent, kAround);
  closed.old = Neighbourhood(map_, agreeing.back().old, kAround);
  MoveMap(shared_.map, moved);
  for (const LoopHypothesis& loop : agreeing) MergePoints(loop);
  ++shared_.revision;
  ++shared_.loops;
  return closed;
}

void LoopCloser::MergePoints(const LoopHypothesis& hypothesis) {
  Map& map = shared_.map;
  for (const auto& [recent, old] : hypothesis.same) {
    const int gone = map.Resolve(recent), kept = map.Resolve(old);
    if (gone < 0 || kept < 0 || gone == kept) continue;
    std::set<int> before;
    for (const Observation& o : map.point(kept).observations) before.insert(o.keyframe);
    map.Merge(gone, kept);
    // What came over was measured against the other point's patch: back to where its corners are.
    for (Observation& o : map.point(kept).observations)
      if (!before.contains(o.keyframe)) {
        const Feature& feature = (*map.keyframe(o.keyframe).features)[o.feature];
        o.img = feature.img;
        o.sigma_px = DetectedSigmaPx(feature.level);
      }
    map.Update(kept);
  }
}

void MoveMap(Map& map, const std::vector<std::pair<int, Similarity3>>& cam_from_world) {
  // New world from old, by keyframe; what a keyframe's unit is multiplied by is its scale.
  std::map<int, Similarity3> new_from_old;
  for (const auto& [id, pose] : cam_from_world)
    new_from_old[id] = pose.Inverse() * Similarity3::FromRigid(map.keyframe(id).cam_from_world);
  for (const MapPoint& point : map.points()) {
    if (!point.alive || point.observations.empty()) continue;
    const auto moved = new_from_old.find(point.observations.front().keyframe);
    if (moved != new_from_old.end()) map.point(point.id).position = moved->second * point.position;
  }
  for (const auto& [id, pose] : cam_from_world) map.keyframe(id).cam_from_world = pose.WithoutScale();
  for (const Keyframe& keyframe : map.keyframes()) {
    const int living = keyframe.alive || keyframe.parent < 0 ? keyframe.id : keyframe.parent;
    const auto moved = new_from_old.find(living);
    if (moved == new_from_old.end()) continue;
    Scale(moved->second.scale, map.keyframe(keyframe.id));
  }
  for (const MapPoint& point : map.points())
    if (point.alive) map.UpdateGeometry(point.id);
}

}  // namespace ulf::tracking
