#include "tracking/map/map.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>
#include <unordered_map>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::tracking {

using Eigen::Vector3d;

void Map::SetCamera(const CameraModel& camera) {
  camera_ = camera;
  for (const int id : living_) {
    Keyframe& keyframe = keyframes_[At(id)];
    keyframe.features = MoveFeatures(camera, *keyframe.features, nullptr, nullptr);
  }
  for (const MapPoint& point : points_)
    if (point.alive) UpdateGeometry(point.id);
}

int Map::AddKeyframe(Keyframe keyframe) {
  keyframe.id = static_cast<int>(keyframes_.size());
  keyframe.point_of_feature.assign(At(keyframe.features->size()), -1);
  keyframe.points = 0;
  if (keyframe.pyramid) keyframe.rows = keyframe.pyramid->rows;
  if (keyframe.rows) keyframe.expected_twist = keyframe.rows->twist();
  keyframes_.push_back(std::move(keyframe));
  if (keyframes_.back().alive) living_.push_back(keyframes_.back().id);
  return keyframes_.back().id;
}

int Map::AddPoint(const Vector3d& position, int part) {
  const int keyframes = static_cast<int>(keyframes_.size());
  MapPoint made;
  made.position = position;
  made.part = part;
  made.first_keyframe = keyframes - 1;
  ++living_points_;
  if (!free_.empty() && free_.front().keyframes + kPointReuseKeyframes <= keyframes) {
    made.id = free_.front().point;
    free_.pop_front();
    point(made.id) = std::move(made);
    return made.id;
  }
  made.id = static_cast<int>(points_.size());
  points_.push_back(std::move(made));
  return points_.back().id;
}

bool Map::AddObservation(int id, const Observation& observation) {
  MapPoint& seen = point(id);
  Keyframe& by = keyframe(observation.keyframe);
  int& slot = by.point_of_feature[At(observation.feature)];
  if (!seen.alive || !by.alive || slot >= 0) return false;
  for (const Observation& other : seen.observations)
    if (other.keyframe == observation.keyframe) return false;
  slot = id;
  ++by.points;
  seen.observations.push_back(observation);
  return true;
}

void Map::AddView(int id, const ViewObservation& seen) {
  std::vector<ViewObservation>& views = point(id).views;
  // The search begins with the newest view, because few views note the same point twice.
  if (std::none_of(views.rbegin(), views.rend(),
                   [&](const ViewObservation& o) { return o.view_id == seen.view_id; }))
    views.push_back(seen);
}

void Map::RemoveObservation(int id, int keyframe_id) {
  MapPoint& seen = point(id);
  const auto found = std::ranges::find_if(seen.observations,
                                          [&](const Observation& o) { return o.keyframe == keyframe_id; });
  if (found == seen.observations.end()) return;
  Keyframe& by = keyframe(keyframe_id);
  by.point_of_feature[At(found->feature)] = -1;
  --by.points;
  seen.observations.erase(found);
  if (seen.observations.size() < 2) RemovePoint(id);
}

void Map::RemovePoint(int id) {
  MapPoint& gone = point(id);
  for (const Observation& observation : gone.observations) {
    Keyframe& by = keyframe(observation.keyframe);
    by.point_of_feature[At(observation.feature)] = -1;
    --by.points;
  }
  if (!gone.alive) return;
  gone.observations = {};
  gone.views = {};
  gone.patch.reset();
  gone.alive = false;
  --living_points_;
  free_.push_back({id, static_cast<int>(keyframes_.size())});
}

std::span<Observation> Map::Merge(int gone_id, int kept_id) {
  if (gone_id == kept_id) return {};
  const std::size_t own = point(kept_id).observations.size();
  const std::vector<Observation> moving = point(gone_id).observations;
  const std::vector<ViewObservation> views = std::move(point(gone_id).views);
  RemovePoint(gone_id);
  for (const Observation& observation : moving) AddObservation(kept_id, observation);
  for (const ViewObservation& view : views) AddView(kept_id, view);
  point(kept_id).found += point(gone_id).found;
  point(kept_id).expected += point(gone_id).expected;
  point(gone_id).merged_into = kept_id;
  return std::span(point(kept_id).observations).subspan(own);
}

// Returns the keyframe that shares most points with it, or the one before it in its part.
int Map::ParentFor(const Keyframe& gone) const {
  if (const std::vector<Neighbour> neighbours = Covisible(gone.id, 1); !neighbours.empty())
    return neighbours.front().keyframe;
  const std::vector<int> part = LivingOf(gone.part);
  if (part.size() < 2) return -1;
  return gone.id == part.front() ? part[1] : *std::prev(std::find(part.begin(), part.end(), gone.id));
}

void Map::RemoveKeyframe(int id) {
  Keyframe& gone = keyframe(id);
  const int parent = ParentFor(gone);
  if (parent < 0) return;
  for (const int point_id : PointsSeenBy(id)) RemoveObservation(point_id, id);
  const auto attach_to_parent = [&](int child_id, const Rigid3& cam_from_world) {
    Keyframe& child = keyframe(child_id);
    child.parent = parent;
    child.cam_from_parent = cam_from_world * keyframe(parent).cam_from_world.Inverse();
    keyframe(parent).children.push_back(child_id);
  };
  for (const int child : gone.children)
    attach_to_parent(child, keyframe(child).cam_from_parent * gone.cam_from_world);
  attach_to_parent(id, gone.cam_from_world);
  std::erase(living_, id);
  Release(gone);
}

void Map::Release(Keyframe& gone) {
  gone.alive = false;
  gone.features.reset();
  gone.pyramid.reset();
  gone.rows.reset();
  gone.color.release();
  gone.point_of_feature = {};
  gone.children = {};
  gone.corners = {};
  gone.points = 0;
}

int Map::Resolve(int id) const {
  while (id >= 0 && !point(id).alive) id = point(id).merged_into;
  return id;
}

Rigid3 Map::PoseOf(int id) const {
  const Keyframe& found = keyframe(id);
  return found.alive || found.parent < 0 ? found.cam_from_world
                                         : found.cam_from_parent * keyframe(found.parent).cam_from_world;
}

Rigid3 Map::PoseOf(const Anchored& anchor) const {
  Rigid3 cam_from_keyframe = anchor.cam_from_keyframe;
  cam_from_keyframe.translation *= keyframe(anchor.keyframe_id).unit / anchor.unit;
  return cam_from_keyframe * PoseOf(anchor.keyframe_id);
}

std::vector<int> Map::PointsSeenBy(int id) const {
  std::vector<int> points;
  for (const int seen : keyframe(id).point_of_feature)
    if (seen >= 0) points.push_back(seen);
  return points;
}

std::vector<int> Map::PointsSeenBy(std::span<const int> keyframes) const {
  std::set<int> points;
  for (const int id : keyframes)
    for (const int seen : keyframe(id).point_of_feature)
      if (seen >= 0) points.insert(seen);
  return {points.begin(), points.end()};
}

double Map::MedianDepth(int id) const {
  std::vector<double> depths;
  for (const int seen : PointsSeenBy(id))
    depths.push_back((keyframe(id).cam_from_world * point(seen).position).z());
  return depths.empty() ? 1 : Median(std::move(depths));
}

std::vector<Map::Neighbour> Map::Covisible(int id, int min_shared) const {
  std::unordered_map<int, int> shared;
  for (const int point_id : keyframe(id).point_of_feature)
    if (point_id >= 0)
      for (const Observation& observation : point(point_id).observations) ++shared[observation.keyframe];
  std::vector<Neighbour> neighbours;
  for (const auto& [other, count] : shared)
    if (other != id && count >= min_shared) neighbours.push_back({other, count});
  std::ranges::sort(neighbours, [](const Neighbour& a, const Neighbour& b) {
    return a.shared != b.shared ? a.shared > b.shared : a.keyframe < b.keyframe;
  });
  return neighbours;
}

void Map::Update(int id) {
  MapPoint& updated = point(id);
  if (!updated.alive || updated.observations.empty()) return;
  UpdateDescriptor(updated);
  UpdateGeometry(id);
}

void Map::UpdateDescriptor(MapPoint& updated) {
  // Choose the descriptor nearest to all others, by (lower) median distance.
  constexpr std::size_t kMost = 12;  // the newest: more cost time. Guessed
  const std::size_t first = updated.observations.size() > kMost ? updated.observations.size() - kMost : 0;
  std::vector<const Descriptor*> descriptors;
  for (std::size_t i = first; i < updated.observations.size(); ++i) {
    const Observation& o = updated.observations[i];
    descriptors.push_back(&(*keyframe(o.keyframe).features)[o.feature].descriptor);
  }
  int least = std::numeric_limits<int>::max();
  std::vector<int> distances(descriptors.size());
  for (const Descriptor* candidate : descriptors) {
    for (std::size_t i = 0; i < descriptors.size(); ++i) distances[i] = Distance(*candidate, *descriptors[i]);
    const auto middle = distances.begin() + static_cast<long>((distances.size() - 1) / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle < least) {
      least = *middle;
      updated.descriptor = *candidate;
    }
  }
}

void Map::UpdateGeometry(int id) {
  MapPoint& updated = point(id);
  if (!updated.alive || updated.observations.empty()) return;
  Vector3d direction = Vector3d::Zero();
  double log_distance = 0;
  for (const Observation& o : updated.observations) {
    const Keyframe& by = keyframe(o.keyframe);
    const Vector3d towards = updated.position - by.cam_from_world.OriginInSource();
    direction += towards.normalized();
    log_distance += std::log(towards.norm() * LevelScale((*by.features)[o.feature].level));
  }
  updated.mean_direction = direction.normalized();
  double least_cosine = 1;
  for (const Observation& o : updated.observations) {
    const Vector3d towards = updated.position - keyframe(o.keyframe).cam_from_world.OriginInSource();
    least_cosine = std::min(least_cosine, towards.normalized().dot(updated.mean_direction));
  }
  updated.parallax = 2 * std::acos(std::clamp(least_cosine, -1.0, 1.0));
  updated.reference_distance = std::exp(log_distance / static_cast<double>(updated.observations.size()));
  constexpr double kMargin = 1.3;  // a descriptor tolerates about as much change of scale. Guessed
  updated.farthest = updated.reference_distance * kMargin;
  updated.nearest = updated.reference_distance / LevelScale(kPyramidLevels - 1) / kMargin;
  if (updated.patch) {
    const auto axes = AxesOf(camera_, PoseOf(updated.patch_keyframe), updated.position, updated.patch->level);
    if (axes) updated.patch_axes = *axes;
  }
}

void Map::SetPatch(int id, const Observation& from) {
  const Keyframe& by = keyframe(from.keyframe);
  if (!by.pyramid) return;
  const int level = (*by.features)[from.feature].level;
  const auto patch = CutPatch(*by.pyramid, from.img, level);
  if (!patch) return;
  MapPoint& updated = point(id);
  updated.patch = std::make_shared<const ReferencePatch>(*patch);
  updated.patch_keyframe = from.keyframe;
}

std::vector<int> Map::Parts() const {
  std::set<int> parts;
  for (const int id : living_) parts.insert(keyframe(id).part);
  return {parts.begin(), parts.end()};
}

std::vector<int> Map::LivingOf(int part) const {
  std::vector<int> of_part;
  std::copy_if(living_.begin(), living_.end(), std::back_inserter(of_part),
               [&](int id) { return keyframe(id).part == part; });
  return of_part;
}

int Map::FirstKeyframe(int part) const {
  const auto first = std::ranges::find_if(living_, [&](int id) { return keyframe(id).part == part; });
  return first == living_.end() ? -1 : *first;
}

void Map::JoinPart(int gone, int kept) {
  for (Keyframe& moved : keyframes_)
    if (moved.part == gone) moved.part = kept;
  for (MapPoint& moved : points_)
    if (moved.part == gone) moved.part = kept;
}

void Map::RemovePart(int part) {
  for (MapPoint& gone : points_) {
    if (gone.part != part) continue;
    for (const Observation& o : gone.observations) keyframe(o.keyframe).point_of_feature.clear();
    gone.observations.clear();
    if (gone.alive) RemovePoint(gone.id);
    gone.merged_into = -1;
  }
  for (Keyframe& gone : keyframes_) {
    if (gone.part != part) continue;
    gone.cam_from_world = PoseOf(gone.id);
    if (!gone.alive) gone.parent = -1;
  }
  for (const int id : LivingOf(part)) {
    Release(keyframe(id));
    std::erase(living_, id);
  }
}

}  // namespace ulf::tracking
