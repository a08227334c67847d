#include "tracking/refine/track_extension.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/base/at.h"
#include "tracking/map/map.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

struct Reference {
  int observation = -1;                   // index into the track's
  Vector3d direction = Vector3d::Zero();  // unit, from its camera to the point
  double distance = 0;
  std::optional<ReferencePatch> patch;
  PatchAxes axes = PatchAxes::Zero();
};

// The corner whose view is nearest the middle of those that see the track.
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
  ForAll(static_cast<int>(scene.views.size()), [&](int v) {
    if (by_view[At(v)].empty()) return;
    const RefineView& view = scene.view(v);
    const Pyramid pyramid = BuildPyramid(view.gray);
    for (const int t : by_view[At(v)]) {
      Reference& reference = references[At(t)];
      const SceneTrack& track = scene.tracks[At(t)];
      const TrackObservation& o = track.observations[At(reference.observation)];
      const Feature& feature = view.features[o.feature];
      const auto axes = AxesOf(scene.LensOf(view), view.cam_from_world, track.position, feature.level);
      reference.patch = CutPatch(pyramid, feature.img, feature.level);
      if (!axes) reference.patch.reset();
      if (axes) reference.axes = *axes;
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
  bool seen_before = false;
};

// Points that the view should show, the longest tracks first.
std::vector<Wanted> WantedIn(const RefineScene& scene, int v, const std::vector<Reference>& references,
                             const std::vector<int>& order, const std::vector<std::uint8_t>& seen,
                             const ExtensionOptions& options) {
  const RefineView& view = scene.view(v);
  const CameraModel& lens = scene.LensOf(view);
  const Vector3d center = view.cam_from_world.OriginInSource();
  const Eigen::Matrix3d rotation = view.cam_from_world.RotationMatrix();
  const double min_cosine = std::cos(options.max_view_change_deg * M_PI / 180);
  const double border = options.border_px;
  std::vector<Wanted> wanted;
  for (const int t : order) {
    const Reference& reference = references[At(t)];
    if (!reference.patch) continue;
    const Vector3d towards = scene.tracks[At(t)].position - center;
    const double distance = towards.norm();
    if (towards.dot(reference.direction) < min_cosine * distance) continue;
    if (distance > options.farthest * reference.distance || distance < options.nearest * reference.distance)
      continue;
    const auto img = lens.ImgFromCam(rotation * towards);
    if (!img || img->x() < border || img->y() < border || img->x() > lens.width - border ||
        img->y() > lens.height - border)
      continue;
    wanted.push_back({t, *img, seen[At(t)] != 0});
  }
  return wanted;
}

std::vector<std::pair<int, TrackObservation>> Measure(const RefineScene& scene, int v,
                                                      const std::vector<Reference>& references,
                                                      const std::vector<Wanted>& wanted,
                                                      const ExtensionOptions& options) {
  const RefineView& view = scene.view(v);
  const CameraModel& lens = scene.LensOf(view);
  const Pyramid pyramid = BuildPyramid(view.gray);
  constexpr int kColumns = 16, kRows = 12;
  const int per_cell = 1 + options.per_view / (kColumns * kRows);
  std::vector<int> found(kColumns * kRows, 0), tried(kColumns * kRows, 0);
  std::vector<std::pair<int, TrackObservation>> measured;
  for (const Wanted& want : wanted) {
    const SceneTrack& track = scene.tracks[At(want.track)];
    const Reference& reference = references[At(want.track)];
    const TrackObservation& origin = track.observations[At(reference.observation)];
    const auto cell =
        At(std::min(kRows - 1, static_cast<int>(want.img.y() * kRows / lens.height)) * kColumns +
           std::min(kColumns - 1, static_cast<int>(want.img.x() * kColumns / lens.width)));
    if (origin.view == v) {
      const Feature& feature = view.features[origin.feature];
      measured.push_back({want.track, {v, origin.feature, feature.img, AlignedSigmaPx(feature.level)}});
      ++found[cell];
      continue;
    }
    if (found[cell] >= per_cell || tried[cell] >= options.tries * per_cell) continue;
    ++tried[cell];
    const auto aligned = AlignPatch(lens, *reference.patch, reference.axes, track.position,
                                    view.cam_from_world, pyramid, want.img, options.alignment);
    if (!aligned || (!want.seen_before && aligned->correlation < options.min_new_correlation)) {
      // Keep the corner that two descriptors agreed on, if there is one.
      const auto corner =
          std::find_if(track.observations.begin(), track.observations.end(),
                       [&](const TrackObservation& o) { return o.view == v && o.feature >= 0; });
      if (corner == track.observations.end()) continue;
      ++found[cell];
      const Feature& feature = view.features[corner->feature];
      measured.push_back({want.track, {v, corner->feature, feature.img, DetectedSigmaPx(feature.level)}});
      continue;
    }
    ++found[cell];
    measured.push_back({want.track, {v, -1, aligned->img, AlignedSigmaPx(aligned->level)}});
  }
  return measured;
}

}  // namespace

void ExtendTracks(const ExtensionOptions& options, RefineScene& scene) {
  const std::vector<Reference> references = CutReferences(scene);
  std::vector<int> order(scene.tracks.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return scene.tracks[At(a)].observations.size() > scene.tracks[At(b)].observations.size();
  });
  std::vector<std::vector<int>> seen_by(scene.views.size());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t)
    for (const TrackObservation& o : scene.tracks[t].observations)
      seen_by[At(o.view)].push_back(static_cast<int>(t));
  std::vector<std::vector<std::pair<int, TrackObservation>>> measured(scene.views.size());
  ForAll(static_cast<int>(scene.views.size()), [&](int v) {
    if (!scene.view(v).registered) return;
    std::vector<std::uint8_t> seen(scene.tracks.size(), 0);
    for (const int t : seen_by[At(v)]) seen[At(t)] = 1;
    measured[At(v)] =
        Measure(scene, v, references, WantedIn(scene, v, references, order, seen, options), options);
  });
  for (SceneTrack& track : scene.tracks) track.observations.clear();
  for (const auto& view : measured)
    for (const auto& [t, observation] : view) scene.tracks[At(t)].observations.push_back(observation);
  std::erase_if(scene.tracks, [](const SceneTrack& track) { return track.observations.size() < 2; });
}

}  // namespace ulf::tracking
