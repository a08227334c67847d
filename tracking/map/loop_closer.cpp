#include "tracking/map/loop_closer.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "tracking/estimation/pose_graph.h"
#include "tracking/estimation/sampling.h"
#include "tracking/features/matching.h"
#include "tracking/map/pose_log_odds.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLoopMemory = 8;  // keyframes until a statement about a loop is forgotten. Guessed
// Median distance between two corrections of the points, of their distance. Guessed.
constexpr double kLoopAgreement = 0.05;
constexpr int kLoopRest = 5;  // keyframes after a closed loop without another search. Guessed
// Candidates: the best ranked that are looked at, and the places among them that are verified. Guessed.
constexpr int kLoopRanked = 30, kLoopCandidates = 3;
// Points to verify a candidate by: matched descriptors, matches that fit one similarity, points that guided
// matching finds, and pairs that tell the scale. Guessed.
constexpr int kLoopMinMatches = 20, kLoopMinSampled = 15, kLoopMinPoints = 40, kLoopMinScalePairs = 15;
// The same for two parts of the map, of which the younger one knows few points yet. Guessed.
constexpr int kLoopMinJoinPoints = 20, kLoopMinJoinScalePairs = 10;
constexpr double kLoopMaxLogScaleSpread = 0.1;  // median deviation; above it the pairs tell no scale. Guessed
constexpr int kLoopMaxDistance = 70;            // bits, of matched descriptors
constexpr double kLoopMaxRatio = 0.85;
constexpr double kLoopSampledSigmas = 4;  // within which a match fits a similarity. Guessed
constexpr int kLoopSamples = 300;
// Larger corrections are no drift, but another place. Guessed.
constexpr double kLoopMaxDrift = 0.25;     // the correction's length over the way since the old part was seen
constexpr double kLoopMaxTurnDeg = 35;     // the correction's rotation
constexpr double kLoopMaxScaleChange = 2;  // the correction's scale, either way
// The pose graph: each keyframe's ties to earlier ones that share at least so many points, or that lie so
// many keyframes back (earlier loops); the weight of keyframes that share none; the weight of the new loop,
// which must hold against many parallel ties. Guessed.
constexpr int kLoopStrongTie = 60, kLoopOldTie = 20;
constexpr double kLoopLooseWeight = 0.1, kLoopLoopWeight = 100;
constexpr int kLoopNeighbourhood = 12;  // keyframes on either side whose points are known or merged. Guessed

// One point in two keyframes: its position in each camera's frame, and where each image shows it.
struct PointPair {
  Vector3d in_recent, in_old;
  Vector2d img_in_recent, img_in_old;
  double recent_sigma_px, old_sigma_px;
};

constexpr int kKeyframeCorners = 1000;       // about so many a keyframe has: they limit the locator's patches
constexpr double kPointsOfUnitWeight = 100;  // a tie by so many shared points has weight 1

double ErrorSigmas2(const CameraModel& camera, const Vector3d& in_cam, const Vector2d& img, double sigma_px) {
  const auto projected = camera.ImgFromCam(in_cam);
  return projected ? (*projected - img).squaredNorm() / (sigma_px * sigma_px) : 1e9;
}

std::optional<Similarity3> SampleSimilarity(const CameraModel& camera, const std::vector<PointPair>& pairs,
                                            bool rigid, unsigned seed) {
  struct Model {
    Similarity3 old_from_recent, recent_from_old;
  };
  const auto fit = [&](const std::vector<int>& chosen) -> std::optional<Model> {
    std::vector<Vector3d> recent, old;
    for (const int i : chosen) {
      recent.push_back(pairs[At(i)].in_recent);
      old.push_back(pairs[At(i)].in_old);
    }
    const auto similarity = AlignPoints(recent, old, rigid);
    if (!similarity || !(similarity->scale > 0)) return std::nullopt;
    return Model{*similarity, similarity->Inverse()};
  };
  const auto residual2 = [&](const Model& model, int i) {
    const PointPair& pair = pairs[At(i)];
    return std::max(
        ErrorSigmas2(camera, model.old_from_recent * pair.in_recent, pair.img_in_old, pair.old_sigma_px),
        ErrorSigmas2(camera, model.recent_from_old * pair.in_old, pair.img_in_recent, pair.recent_sigma_px));
  };
  const auto found = SampleConsensusByFit<Model>(
      static_cast<int>(pairs.size()), 3, fit, residual2,
      {.threshold = kLoopSampledSigmas, .max_iterations = kLoopSamples, .seed = seed});
  if (!found || static_cast<int>(found->inliers.size()) < kLoopMinSampled) return std::nullopt;
  return found->model.recent_from_old;
}

// Scales everything that is measured in the keyframe's unit, except its pose.
void Scale(double scale, Keyframe& keyframe) {
  keyframe.unit *= scale;
  if (!keyframe.alive) keyframe.cam_from_parent.translation *= scale;
  if (keyframe.velocity) keyframe.velocity->tail<3>() *= scale;
  if (keyframe.expected_twist) keyframe.expected_twist->tail<3>() *= scale;
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

// Returns a keyframe and the keyframes that share most points with it, `most` together.
std::vector<int> Neighbourhood(const Map& map, int keyframe, int most) {
  std::vector<int> around{keyframe};
  for (const Map::Neighbour& neighbour : map.Covisible(keyframe))
    if (static_cast<int>(around.size()) < most) around.push_back(neighbour.keyframe);
  return around;
}

}  // namespace

LoopCloser::LoopCloser(const CameraModel& camera, OwnedMap& owned, const KeyframeIndex& index, unsigned seed,
                       int agreeing)
    : camera_(camera),
      owned_(owned),
      map_(owned.shared.ReadByOwner()),
      index_(index),
      seed_(seed),
      agreeing_(agreeing),
      locator_(camera, owned.shared, kKeyframeCorners) {}

void LoopCloser::SetCamera(const CameraModel& camera) {
  camera_ = camera;
  locator_.SetCamera(camera);
}

void LoopCloser::Reset() {
  pending_.clear();
  last_closed_ = -1;
}

// Keyframes of different places that look like this one and share no points with its surroundings.
std::vector<int> LoopCloser::Candidates(int newest) const {
  std::set<int> taken{newest};
  const auto take_with_neighbours = [&](int keyframe) {
    taken.insert(keyframe);
    for (const Map::Neighbour& neighbour : map_.Covisible(keyframe)) taken.insert(neighbour.keyframe);
  };
  for (const Map::Neighbour& neighbour : map_.Covisible(newest)) take_with_neighbours(neighbour.keyframe);
  std::vector<int> candidates;
  for (const auto& [keyframe, votes] : index_.Query(*map_.keyframe(newest).features, kLoopRanked)) {
    if (static_cast<int>(candidates.size()) >= kLoopCandidates) break;
    if (!map_.keyframe(keyframe).alive || taken.contains(keyframe)) continue;
    candidates.push_back(keyframe);
    take_with_neighbours(keyframe);
  }
  return candidates;
}

// Returns where the old part's world has the recent camera, about: by points that both keyframes know; of two
// parts, where too few are known, by the old points that the recent image shows.
std::optional<Rigid3> LoopCloser::Propose(int recent_id, const KeyframePoints& of_recent, int old_id,
                                          const KeyframePoints& of_old, bool rigid) const {
  const Keyframe &recent = map_.keyframe(recent_id), &old = map_.keyframe(old_id);
  const unsigned seed = seed_ + static_cast<unsigned>(recent_id);
  const auto matches = MatchAll(*recent.features, of_recent.with_points, *old.features, of_old.with_points,
                                {.max_distance = kLoopMaxDistance, .max_ratio = kLoopMaxRatio});
  std::vector<PointPair> pairs;
  for (const FeatureMatch& match : matches) {
    const Feature &a = (*recent.features)[match.first], &b = (*old.features)[match.second];
    pairs.push_back({recent.cam_from_world * of_recent.positions[At(match.first)],
                     old.cam_from_world * of_old.positions[At(match.second)], a.img, b.img,
                     DetectedSigmaPx(a.level), DetectedSigmaPx(b.level)});
  }
  if (static_cast<int>(pairs.size()) >= kLoopMinMatches)
    if (const auto recent_from_old = SampleSimilarity(camera_, pairs, rigid, seed))
      return (*recent_from_old * Similarity3::FromRigid(old.cam_from_world)).WithoutScale();
  if (recent.part == old.part) return std::nullopt;
  return ProposePose(camera_, of_old, *recent.features, seed);
}

std::optional<LoopHypothesis> LoopCloser::Verify(int recent_id, int old_id) const {
  const Keyframe &recent = map_.keyframe(recent_id), &old = map_.keyframe(old_id);
  const bool rigid = recent.part == old.part && ScaleIsGiven(owned_.shared);
  const KeyframePoints of_recent = PointsOf(map_, recent_id), of_old = PointsOf(map_, old_id);
  const bool joins = recent.part != old.part;
  const std::optional<Rigid3> proposal = Propose(recent_id, of_recent, old_id, of_old, rigid);
  if (!proposal) return std::nullopt;

  // Match the recent keyframe with all points of the old part, in the old part's world.
  FramePose frame_pose;
  frame_pose.cam_from_world = *proposal;
  frame_pose.candidates = GatherCandidates(map_, camera_, frame_pose.cam_from_world, old.part);
  const auto points_about = [&](int keyframe) {
    return map_.PointsSeenBy(Neighbourhood(map_, keyframe, kLoopNeighbourhood));
  };
  const std::vector<int> known = points_about(old_id), own = points_about(recent_id);
  const auto holds = [](const std::vector<int>& ids, int id) {
    return std::binary_search(ids.begin(), ids.end(), id);
  };
  std::erase_if(frame_pose.candidates,
                [&](const Candidate& c) { return !holds(known, c.id) || holds(own, c.id); });
  const TrackedImage image{recent.time_s, recent.pyramid, recent.features};
  const std::optional<FramePose> found = locator_.RefineTwice(image, std::move(frame_pose));
  ExcludedCandidates left_out;
  if (found && joins) ExcludeAmbiguousMatches(camera_, *recent.features, *found, left_out);
  if (!found || static_cast<int>(found->matches.size()) < (joins ? kLoopMinJoinPoints : kLoopMinPoints) ||
      PoseLogOdds(camera_, *found) <= kRelocalizedLogOdds ||
      (joins && PoseLogOdds(camera_, *found, left_out) <= kFollowedLogOdds)) {
    spdlog::debug("loop {} to {}: {} of {:.0f} points: not sure", recent_id, old_id,
                  found ? found->matches.size() : 0, found ? found->expected : 0.0);
    return std::nullopt;
  }

  LoopHypothesis hypothesis;
  std::vector<double> log_scales;
  for (const PointMatch& match : found->matches) {
    if (match.feature < 0) continue;
    const int point = recent.point_of_feature[At(match.feature)];
    if (point < 0) continue;
    const Candidate& candidate = found->CandidateOf(match);
    hypothesis.same.emplace_back(point, candidate.id);
    log_scales.push_back(std::log((recent.cam_from_world * map_.point(point).position).norm() /
                                  (found->cam_from_world * candidate.position).norm()));
  }
  if (static_cast<int>(log_scales.size()) < (joins ? kLoopMinJoinScalePairs : kLoopMinScalePairs))
    return std::nullopt;
  const double log_scale = Median(log_scales);
  for (double& value : log_scales) value = std::abs(value - log_scale);
  if (Median(log_scales) > kLoopMaxLogScaleSpread) return std::nullopt;
  hypothesis.recent = recent_id;
  hypothesis.old = old_id;
  hypothesis.points = static_cast<int>(found->matches.size());
  Similarity3 recent_from_world = Similarity3::FromRigid(found->cam_from_world);
  if (rigid) {
    if (std::abs(log_scale) > kLoopMaxLogScaleSpread) return std::nullopt;
  } else {
    recent_from_world.scale = std::exp(log_scale);
    recent_from_world.translation *= recent_from_world.scale;
  }
  hypothesis.recent_from_old = recent_from_world * Similarity3::FromRigid(old.cam_from_world).Inverse();
  spdlog::debug("loop {} to {}: {} of {:.0f} points, scale {:.4f}", recent_id, old_id, hypothesis.points,
                found->expected, recent_from_world.scale);
  return hypothesis;
}

// Moves the world about the recent camera to its place in the old part.
Similarity3 LoopCloser::Correction(const LoopHypothesis& hypothesis) const {
  const auto pose = [&](int keyframe) { return Similarity3::FromRigid(map_.PoseOf(keyframe)); };
  return pose(hypothesis.old).Inverse() * hypothesis.recent_from_old.Inverse() * pose(hypothesis.recent);
}

bool LoopCloser::JoinsParts(const LoopHypothesis& hypothesis) const {
  return map_.keyframe(hypothesis.recent).part != map_.keyframe(hypothesis.old).part;
}

bool LoopCloser::Plausible(const LoopHypothesis& hypothesis) const {
  if (JoinsParts(hypothesis)) return true;
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
  const double turned_deg = Degrees(Eigen::AngleAxisd(correction.rotation).angle());
  const bool plausible = moved <= kLoopMaxDrift * way && turned_deg <= kLoopMaxTurnDeg &&
                         std::abs(std::log(correction.scale)) <= std::log(kLoopMaxScaleChange);
  if (!plausible)
    spdlog::debug("loop {} to {}: not drift: {:.3f} over a way of {:.3f}, {:.1f} degrees, scale {:.3f}",
                  hypothesis.recent, hypothesis.old, moved, way, turned_deg, correction.scale);
  return plausible;
}

bool LoopCloser::Agree(const LoopHypothesis& a, const LoopHypothesis& b) const {
  const Similarity3 by_a = Correction(a), by_b = Correction(b);
  const Vector3d center = map_.keyframe(a.recent).cam_from_world.OriginInSource();
  std::vector<double> apart;
  for (const int point : map_.PointsSeenBy(a.recent)) {
    const Vector3d& position = map_.point(point).position;
    apart.push_back((by_a * position - by_b * position).norm() / (by_a.scale * (position - center).norm()));
  }
  return !apart.empty() && Median(std::move(apart)) < kLoopAgreement;
}

std::optional<ClosedLoop> LoopCloser::Examine(int newest) {
  if (last_closed_ >= 0 && newest < last_closed_ + kLoopRest) return std::nullopt;
  std::erase_if(pending_, [&](const LoopHypothesis& h) {
    return h.recent < newest - kLoopMemory || !map_.keyframe(h.recent).alive || !map_.keyframe(h.old).alive;
  });
  std::vector<LoopHypothesis> verified;
  for (const int candidate : Candidates(newest))
    if (auto hypothesis = Verify(newest, candidate); hypothesis && Plausible(*hypothesis))
      verified.push_back(std::move(*hypothesis));
  if (verified.empty()) return std::nullopt;
  // Each other part may show this place in its own world: one is joined at a time.
  const int part = map_.keyframe(verified.front().old).part;
  const auto elsewhere = [&](const LoopHypothesis& h) { return map_.keyframe(h.old).part != part; };
  std::erase_if(verified, elsewhere);
  std::erase_if(pending_, elsewhere);
  // Two places look like this one: drop both, and the hypotheses of earlier keyframes.
  for (const LoopHypothesis& other : verified)
    if (!Agree(verified.front(), other)) {
      spdlog::debug("loop {}: {} and {} contradict each other", newest, verified.front().old, other.old);
      pending_.clear();
      return std::nullopt;
    }
  std::erase_if(pending_, [&](const LoopHypothesis& h) { return !Agree(verified.front(), h); });
  pending_.push_back(verified.front());
  if (static_cast<int>(pending_.size()) < agreeing_) return std::nullopt;
  const std::vector<LoopHypothesis> agreeing = std::exchange(pending_, {});
  auto closed = JoinsParts(agreeing.back()) ? Join(agreeing) : Close(agreeing);
  if (closed) last_closed_ = newest;
  return closed;
}

std::optional<ClosedLoop> LoopCloser::Close(const std::vector<LoopHypothesis>& agreeing) {
  PoseGraph graph;
  std::map<int, int> node_of;
  std::vector<int> keyframes;
  const int part = map_.keyframe(agreeing.back().recent).part;
  for (const Keyframe& keyframe : map_.keyframes()) {
    if (!keyframe.alive || keyframe.part != part) continue;
    node_of[keyframe.id] = static_cast<int>(keyframes.size());
    keyframes.push_back(keyframe.id);
    graph.cam_from_world.push_back(Similarity3::FromRigid(keyframe.cam_from_world));
    graph.fixed.push_back(keyframe.pinned || keyframe.id == map_.FirstKeyframe(part));
  }
  const auto add_edge = [&](int from, int to, double weight) {
    const std::size_t a = At(node_of.at(from)), b = At(node_of.at(to));
    graph.edges.push_back({static_cast<int>(a), static_cast<int>(b),
                           graph.cam_from_world[b] * graph.cam_from_world[a].Inverse(), weight});
  };
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    bool tied = false;  // to an earlier one: the strongest of these edges is always kept
    for (const Map::Neighbour& neighbour : map_.Covisible(keyframes[i])) {
      const int apart = keyframes[i] - neighbour.keyframe;
      if (apart < 0 || (tied && neighbour.shared < kLoopStrongTie && apart < kLoopOldTie)) continue;
      add_edge(neighbour.keyframe, keyframes[i], neighbour.shared / kPointsOfUnitWeight);
      tied = true;
    }
    if (!tied) add_edge(keyframes[i - 1], keyframes[i], kLoopLooseWeight);
  }
  // A loop is measured as accurately as one step of the way. So it must not yield to the drift of all steps,
  // nor to the way's many parallel ties, which repeat one measurement.
  for (const LoopHypothesis& loop : agreeing)
    graph.edges.push_back({node_of.at(loop.old), node_of.at(loop.recent), loop.recent_from_old,
                           kLoopLoopWeight * loop.points / kPointsOfUnitWeight});
  const PoseGraphSummary solved = OptimizePoseGraph(
      graph, {.rigid = ScaleIsGiven(owned_.shared), .unit = map_.MedianDepth(agreeing.back().recent)});
  spdlog::debug("loop {} to {} closed: pose graph of {} keyframes and {} edges, cost {:.4g} -> {:.4g}",
                agreeing.back().recent, agreeing.back().old, keyframes.size(), graph.edges.size(),
                solved.initial_cost, solved.final_cost);
  if (!solved.usable) return std::nullopt;

  const ClosedLoop closed = Seen(agreeing.back());
  const MapLock lock(owned_.shared);
  std::vector<std::pair<int, Similarity3>> moved;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    moved.emplace_back(keyframes[i], graph.cam_from_world[i]);
  MoveMap(owned_.map, moved);
  for (const LoopHypothesis& loop : agreeing) MergePoints(loop);
  ++owned_.shared.revision;
  ++owned_.shared.loops;
  return closed;
}

// Returns the keyframes on either side, before points are merged.
ClosedLoop LoopCloser::Seen(const LoopHypothesis& last) const {
  return {Neighbourhood(map_, last.recent, kLoopNeighbourhood),
          Neighbourhood(map_, last.old, kLoopNeighbourhood)};
}

// The main part stays where it is; of two others, the older one does.
ClosedLoop LoopCloser::Join(const std::vector<LoopHypothesis>& agreeing) {
  const LoopHypothesis& best = *std::ranges::max_element(agreeing, {}, &LoopHypothesis::points);
  const int recent = map_.keyframe(best.recent).part, old = map_.keyframe(best.old).part;
  const bool old_stays = old == map_.main_part() || (recent != map_.main_part() && old < recent);
  const Similarity3 old_from_recent = Correction(best);
  const Similarity3 kept_from_gone = old_stays ? old_from_recent : old_from_recent.Inverse();
  const int gone = old_stays ? recent : old, kept = old_stays ? old : recent;
  const ClosedLoop seen = Seen(best);
  const MapLock lock(owned_.shared);
  std::vector<std::pair<int, Similarity3>> moved;
  for (const int id : map_.LivingOf(gone))
    moved.emplace_back(id,
                       Similarity3::FromRigid(map_.keyframe(id).cam_from_world) * kept_from_gone.Inverse());
  MoveMap(owned_.map, moved);
  owned_.map.JoinPart(gone, kept);
  for (const LoopHypothesis& loop : agreeing) MergePoints(loop);
  ++owned_.shared.revision;
  ++owned_.shared.joins;
  spdlog::debug("part {} joined to part {} by keyframes {} and {}: {} keyframes moved, scale {:.4f}", gone,
                kept, best.recent, best.old, moved.size(), kept_from_gone.scale);
  return seen;
}

void LoopCloser::MergePoints(const LoopHypothesis& hypothesis) {
  Map& map = owned_.map;
  for (const auto& [recent, old] : hypothesis.same) {
    const int gone = map.Resolve(recent), kept = map.Resolve(old);
    if (gone < 0 || kept < 0 || gone == kept) continue;
    // The moved observations were measured against the other point's patch: use their corners instead.
    for (Observation& o : map.Merge(gone, kept)) {
      const Feature& feature = (*map.keyframe(o.keyframe).features)[o.feature];
      o.img = feature.img;
      o.sigma_px = DetectedSigmaPx(feature.level);
    }
    map.Update(kept);
  }
}

void MoveMap(Map& map, const std::vector<std::pair<int, Similarity3>>& cam_from_world) {
  // New world from old, by keyframe; its scale is the factor of the keyframe's unit.
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
