#include "tracking/refine/track_extension.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/geometry/angles.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

constexpr int kExtensionColumns = 16,
              kExtensionRows = 12;  // of that grid: more cells spread the points more evenly. Guessed
constexpr double kExtensionMaxViewChangeDeg = 45;  // from where the reference patch was taken. Guessed
constexpr double kExtensionNearest = 0.4,
                 kExtensionFarthest = 2.5;  // distances, of the reference view's. Guessed
constexpr double kExtensionBorderPx = 12;   // at the image's edge, without room for a patch
// Patches tried for one that is found, in a cell that is not full. Guessed.
constexpr int kExtensionTries = 3;
constexpr PatchAlignmentOptions kExtensionAlignment = {};
// A patch without a corner match must look more alike than one with it. Guessed.
constexpr double kExtensionMinNewCorrelation = 0.9;

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
                                    view.cam_from_world, pyramid, want.img, kExtensionAlignment);
    const auto before = std::find_if(track.observations.begin(), track.observations.end(),
                                     [&](const TrackObservation& o) { return o.view == v; });
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
