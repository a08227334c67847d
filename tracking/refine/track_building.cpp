#include "tracking/refine/track_building.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/geometry/angles.h"
#include "core/geometry/triangulation.h"
#include "tracking/features/patch_alignment.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// The largest parallax between two of a track's views, at least; less leaves its depth open. Guessed.
constexpr double kTrackMinParallaxDeg = 1;
// The grid of cells over a view in which tracks compete: more cells spread the tracks more evenly. Guessed.
constexpr int kTrackColumns = 10, kTrackRows = 8;
// Pairs of observations that are tried where not all agree: more cost time. Guessed.
constexpr int kTrackTriedPairs = 12;

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

// It is approximate: from the first centre to the farthest, and from there to the farthest again.
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
    if (std::ranges::none_of(track.observations, has_room)) continue;
    for (const TrackObservation& o : track.observations) ++crowd[cell_of(o)];
    chosen.push_back(std::move(track));
  }
  scene.tracks = std::move(chosen);
}

// ---- Measuring tracks in every view ----

// The grid of cells over a view: more cells spread the points more evenly. Guessed.
constexpr int kExtensionColumns = 16, kExtensionRows = 12;
// A view may look at a point from so far aside of the reference view, and from distances between these shares
// of the reference view's. Guessed.
constexpr double kExtensionMaxViewChangeDeg = 45;
constexpr double kExtensionNearest = 0.4, kExtensionFarthest = 2.5;
constexpr double kExtensionBorderPx = 12;  // at the image's edge, without room for a patch
// Patches that are tried for one that is found, in a cell that is not full. Guessed.
constexpr int kExtensionTries = 3;
// A patch without a corner match must look more alike than one with it. Guessed.
constexpr double kExtensionMinNewCorrelation = 0.9;

struct Reference {
  int observation = -1;                   // index into the track's
  Vector3d direction = Vector3d::Zero();  // unit, from its camera to the point
  double distance = 0;
  std::optional<ReferencePatch> patch;
  PatchAxes axes = PatchAxes::Zero();
};

// Returns the corner whose view is nearest the middle of those that see the track.
int MiddleObservation(const RefineScene& scene, const SceneTrack& track) {
  Vector3d mean = Vector3d::Zero();
  for (const TrackObservation& o : track.observations)
    mean += (track.position - scene.view(o.view).cam_from_world.OriginInSource()).normalized();
  int middle = -1;
  double best = -2;
  for (int i = 0; i < static_cast<int>(track.observations.size()); ++i) {
    const TrackObservation& o = track.observations[At(i)];
    if (o.feature < 0) continue;
    const double cosine = mean.normalized().dot(
        (track.position - scene.view(o.view).cam_from_world.OriginInSource()).normalized());
    if (cosine > best) {
      best = cosine;
      middle = i;
    }
  }
  return middle;
}

std::vector<Reference> CutReferences(const RefineScene& scene) {
  std::vector<Reference> references(scene.tracks.size());
  std::vector<std::vector<int>> by_view(scene.views.size());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    references[t].observation = MiddleObservation(scene, scene.tracks[t]);
    if (references[t].observation >= 0)
      by_view[At(scene.tracks[t].observations[At(references[t].observation)].view)].push_back(
          static_cast<int>(t));
  }
  ParallelFor(scene.views.size(), [&](std::size_t v) {
    if (by_view[v].empty()) return;
    const RefineView& view = scene.views[v];
    const Pyramid pyramid = BuildPyramid(view.gray);
    for (const int t : by_view[v]) {
      Reference& reference = references[At(t)];
      const SceneTrack& track = scene.tracks[At(t)];
      const TrackObservation& o = track.observations[At(reference.observation)];
      const Feature& feature = view.features[o.feature];
      const auto axes = AxesOf(scene.LensOf(view), view.cam_from_world, track.position, feature.level);
      if (!axes) continue;
      reference.axes = *axes;
      reference.patch = CutPatch(pyramid, feature.img, feature.level);
      const Vector3d towards = track.position - view.cam_from_world.OriginInSource();
      reference.distance = towards.norm();
      reference.direction = towards.normalized();
    }
  });
  return references;
}

struct Wanted {
  int track = 0;
  Eigen::Vector2d img;
};

// Points that the view should show, in the order given.
std::vector<Wanted> WantedIn(const RefineScene& scene, int v, const std::vector<Reference>& references,
                             const std::vector<int>& order) {
  const RefineView& view = scene.view(v);
  const CameraModel& lens = scene.LensOf(view);
  const Vector3d center = view.cam_from_world.OriginInSource();
  const Eigen::Matrix3d rotation = view.cam_from_world.RotationMatrix();
  const double min_cosine = std::cos(Radians(kExtensionMaxViewChangeDeg));
  const double border = kExtensionBorderPx;
  std::vector<Wanted> wanted;
  for (const int t : order) {
    const Reference& reference = references[At(t)];
    if (!reference.patch) continue;
    const Vector3d towards = scene.tracks[At(t)].position - center;
    const double distance = towards.norm();
    if (towards.dot(reference.direction) < min_cosine * distance) continue;
    if (distance > kExtensionFarthest * reference.distance ||
        distance < kExtensionNearest * reference.distance)
      continue;
    const auto img = lens.ImgFromCam(rotation * towards);
    if (!img || img->x() < border || img->y() < border || img->x() > lens.width - border ||
        img->y() > lens.height - border)
      continue;
    wanted.push_back({t, *img});
  }
  return wanted;
}

std::vector<std::pair<int, TrackObservation>> Measure(const RefineScene& scene, int v,
                                                      const std::vector<Reference>& references,
                                                      const std::vector<Wanted>& wanted, int per_view) {
  const RefineView& view = scene.view(v);
  const CameraModel& lens = scene.LensOf(view);
  const Pyramid pyramid = BuildPyramid(view.gray);
  const int cells = kExtensionColumns * kExtensionRows, per_cell = 1 + per_view / cells;
  std::vector<int> found(At(cells), 0), tried(At(cells), 0);
  std::vector<std::pair<int, TrackObservation>> measured;
  for (const Wanted& want : wanted) {
    const SceneTrack& track = scene.tracks[At(want.track)];
    const Reference& reference = references[At(want.track)];
    const TrackObservation& origin = track.observations[At(reference.observation)];
    const std::size_t cell = CellOf(want.img, lens, kExtensionColumns, kExtensionRows);
    const auto measure = [&](int feature, const Eigen::Vector2d& img, double sigma_px) {
      measured.push_back({want.track, {v, feature, img, sigma_px}});
      ++found[cell];
    };
    if (origin.view == v) {
      const Feature& feature = view.features[origin.feature];
      measure(origin.feature, feature.img, AlignedSigmaPx(feature.level));
      continue;
    }
    if (found[cell] >= per_cell || tried[cell] >= kExtensionTries * per_cell) continue;
    ++tried[cell];
    const auto aligned = AlignPatch(lens, *reference.patch, reference.axes, track.position,
                                    view.cam_from_world, pyramid, want.img);
    const auto before =
        std::ranges::find_if(track.observations, [&](const TrackObservation& o) { return o.view == v; });
    const bool seen_before = before != track.observations.end();
    if (aligned && (seen_before || aligned->correlation >= kExtensionMinNewCorrelation)) {
      measure(-1, aligned->img, AlignedSigmaPx(aligned->level));
    } else if (seen_before && before->feature >= 0) {  // keep the corner that two descriptors agreed on
      const Feature& feature = view.features[before->feature];
      measure(before->feature, feature.img, DetectedSigmaPx(feature.level));
    }
  }
  return measured;
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
  // If not all agree, try pairs that are far apart in the order of views.
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
  std::ranges::stable_sort(links, {}, [](const Link& link) { return link.match.distance; });
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

void ExtendTracks(int per_view, RefineScene& scene) {
  const std::vector<Reference> references = CutReferences(scene);
  const std::vector<int> order = scene.LongestFirst();
  std::vector<std::vector<std::pair<int, TrackObservation>>> measured(scene.views.size());
  ParallelFor(scene.views.size(), [&](std::size_t i) {
    const int v = static_cast<int>(i);
    if (scene.views[i].registered)
      measured[i] = Measure(scene, v, references, WantedIn(scene, v, references, order), per_view);
  });
  for (SceneTrack& track : scene.tracks) track.observations.clear();
  for (const auto& view : measured)
    for (const auto& [t, observation] : view) scene.tracks[At(t)].observations.push_back(observation);
  scene.DropShortTracks(2);
}

}  // namespace ulf::tracking
