#include "tracking/refine/track_building.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/geometry/angles.h"
#include "core/geometry/triangulation.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// Largest between two of a track's views; less leaves its depth open. Guessed
constexpr double kTrackMinParallaxDeg = 1;
constexpr int kTrackColumns = 10,
              kTrackRows = 8;         // of that grid: more spread the tracks more evenly. Guessed
constexpr int kTrackTriedPairs = 12;  // of observations, where not all agree: more cost time. Guessed

struct TrackCorner {
  int view = 0, feature = 0;
};

// Disjoint sets of corners, none with two of one view.
class TrackSets {
 public:
  explicit TrackSets(const RefineScene& scene) {
    first_.push_back(0);
    for (const RefineView& view : scene.views) first_.push_back(first_.back() + view.features.size());
    parent_.resize(At(first_.back()));
    std::iota(parent_.begin(), parent_.end(), 0);
    members_.resize(parent_.size());
  }

  void Join(const TrackCorner& a, const TrackCorner& b) {
    int to = RootOf(a), from = RootOf(b);
    if (to == from) return;
    if (Members(to).size() < Members(from).size()) std::swap(to, from);
    std::vector<TrackCorner>& kept = Members(to);
    std::vector<TrackCorner>& gone = Members(from);
    std::vector<TrackCorner> merged(kept.size() + gone.size());
    const auto by_view = [](const TrackCorner& x, const TrackCorner& y) { return x.view < y.view; };
    std::merge(kept.begin(), kept.end(), gone.begin(), gone.end(), merged.begin(), by_view);
    for (std::size_t i = 1; i < merged.size(); ++i)
      if (merged[i].view == merged[i - 1].view) return;
    kept = std::move(merged);
    gone = {};
    parent_[At(from)] = to;
  }

  std::vector<std::vector<TrackCorner>> Sets() {
    std::vector<std::vector<TrackCorner>> sets;
    for (std::vector<TrackCorner>& set : members_)
      if (set.size() > 1) sets.push_back(std::move(set));
    return sets;
  }

 private:
  int RootOf(const TrackCorner& corner) {
    int node = first_[At(corner.view)] + corner.feature;
    std::vector<TrackCorner>& own = members_[At(node)];
    if (parent_[At(node)] == node && own.empty()) own.push_back(corner);
    while (parent_[At(node)] != node) {
      int& above = parent_[At(node)];
      above = parent_[At(above)];
      node = above;
    }
    return node;
  }
  std::vector<TrackCorner>& Members(int root) { return members_[At(root)]; }

  std::vector<int> first_, parent_;
  std::vector<std::vector<TrackCorner>> members_;
};

// About: from the first centre to the farthest, and from there to the farthest again.
double LargestParallax(const RefineScene& scene, const SceneTrack& track) {
  double largest = 0;
  Vector3d from = scene.view(track.observations.front().view).cam_from_world.OriginInSource();
  for (int round = 0; round < 2; ++round) {
    Vector3d farthest = from;
    double angle = 0;
    for (const TrackObservation& o : track.observations) {
      const Vector3d center = scene.view(o.view).cam_from_world.OriginInSource();
      const double at = ParallaxAngle(track.position, from, center);
      if (at > angle) {
        angle = at;
        farthest = center;
      }
    }
    largest = std::max(largest, angle);
    from = farthest;
  }
  return largest;
}

RayObservation RayOf(const RefineScene& scene, const TrackObservation& seen) {
  const RefineView& view = scene.view(seen.view);
  const auto ray = scene.LensOf(view).RayFromImg(seen.img);
  return {view.cam_from_world, ray.value_or(Vector3d::UnitZ())};
}

// Keeps tracks, the longest first, while one of their views has room in the cell that shows them.
void SelectTracks(const TrackOptions& options, RefineScene& scene) {
  const int cells = kTrackColumns * kTrackRows;
  const int per_cell = std::max(1, options.per_view / cells);
  std::vector<std::uint16_t> crowd(scene.views.size() * At(cells), 0);
  const auto cell_of = [&](const TrackObservation& o) {
    const CameraModel& lens = scene.LensOf(scene.view(o.view));
    return At(o.view * cells) + CellOf(o.img, lens, kTrackColumns, kTrackRows);
  };
  std::vector<SceneTrack> chosen;
  for (const int t : scene.LongestFirst()) {
    SceneTrack& track = scene.tracks[At(t)];
    const auto has_room = [&](const TrackObservation& o) { return crowd[cell_of(o)] < per_cell; };
    if (std::none_of(track.observations.begin(), track.observations.end(), has_room)) continue;
    for (const TrackObservation& o : track.observations) ++crowd[cell_of(o)];
    chosen.push_back(std::move(track));
  }
  scene.tracks = std::move(chosen);
}

}  // namespace

bool TriangulateRobustly(const RefineScene& scene, const TrackOptions& options, SceneTrack& track) {
  const auto& all = track.observations;
  const int count = static_cast<int>(all.size());
  if (count < options.min_views) return false;
  const auto inliers_of = [&](const Vector3d& position) {
    SceneTrack guess;
    guess.position = position;
    std::vector<TrackObservation> inliers;
    for (const TrackObservation& o : all)
      if (ReprojectionErrorPx(scene, guess, o) < options.gate_px * std::max(1.0, o.sigma_px))
        inliers.push_back(o);
    return inliers;
  };
  std::vector<TrackObservation> best;
  Vector3d position = Vector3d::Zero();
  const auto offer = [&](const std::optional<Vector3d>& point) {
    if (!point) return;
    std::vector<TrackObservation> inliers = inliers_of(*point);
    if (inliers.size() <= best.size()) return;
    best = std::move(inliers);
    position = *point;
  };
  std::vector<RayObservation> rays;
  for (const TrackObservation& o : all) rays.push_back(RayOf(scene, o));
  offer(TriangulatePoint(rays));
  // Where not all agree, try pairs that are far apart in the order of views.
  for (int k = 0; k < std::min(count, kTrackTriedPairs) && static_cast<int>(best.size()) < count; ++k) {
    const auto a = At(k), b = At((k + count / 2) % count);
    if (a != b)
      offer(TriangulatePoint(rays[a].cam_from_world, rays[a].ray_in_cam, rays[b].cam_from_world,
                             rays[b].ray_in_cam));
  }
  if (static_cast<int>(best.size()) < options.min_views) return false;
  if (static_cast<int>(best.size()) < count) {
    rays.clear();
    for (const TrackObservation& o : best) rays.push_back(RayOf(scene, o));
    if (const auto refined = TriangulatePoint(rays)) position = *refined;
  }
  track.observations = std::move(best);
  track.position = position;
  return LargestParallax(scene, track) > Radians(kTrackMinParallaxDeg);
}

void BuildTracks(const std::vector<PairMatches>& pairs, const TrackOptions& options, RefineScene& scene) {
  struct Link {
    const PairMatches* pair;
    FeatureMatch match;
  };
  std::vector<Link> links;
  for (const PairMatches& pair : pairs)
    for (const FeatureMatch& match : pair.matches) links.push_back({&pair, match});
  std::stable_sort(links.begin(), links.end(),
                   [](const Link& a, const Link& b) { return a.match.distance < b.match.distance; });
  TrackSets sets(scene);
  for (const auto& [pair, match] : links) sets.Join({pair->first, match.first}, {pair->second, match.second});
  scene.tracks.clear();
  for (const std::vector<TrackCorner>& corners : sets.Sets()) {
    if (static_cast<int>(corners.size()) < options.min_views) continue;
    SceneTrack track;
    for (const TrackCorner& corner : corners) {
      const RefineView& view = scene.view(corner.view);
      const Feature& feature = view.features[corner.feature];
      track.observations.push_back(
          {corner.view, corner.feature, feature.img, DetectedSigmaPx(feature.level)});
    }
    track.rgb = scene.view(corners.front().view).feature_rgb[At(corners.front().feature)];
    scene.tracks.push_back(std::move(track));
  }
  ParallelFor(scene.tracks.size(), [&](std::size_t t) {
    if (!TriangulateRobustly(scene, options, scene.tracks[t])) scene.tracks[t].observations.clear();
  });
  scene.DropShortTracks(1);
  SelectTracks(options, scene);
}

}  // namespace ulf::tracking
