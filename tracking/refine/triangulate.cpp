#include "tracking/refine/triangulate.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/light_field/points/point_fit.h"
#include "tracking/refine/track_building.h"
#include "tracking/refine/track_extension.h"
#include "tracking/refine/view_matching.h"

namespace ulf::tracking {
namespace {

PosedObservation ObservationOf(const RefineScene& scene, const TrackObservation& seen) {
  const RefineView& view = scene.view(seen.view);
  return {&scene.LensOf(view), &view.cam_from_world, seen.img};
}

// Fits every track's position to its observations. A track that fits nowhere loses all of them.
void FitPositions(RefineScene& scene) {
  ForAll(static_cast<int>(scene.tracks.size()), [&](int t) {
    SceneTrack& track = scene.tracks[At(t)];
    std::vector<PosedObservation> observations;
    for (const TrackObservation& seen : track.observations)
      observations.push_back(ObservationOf(scene, seen));
    const auto position = FitPoint(observations);
    if (position)
      track.position = *position;
    else
      track.observations.clear();
  });
}

// Drops observations that are off by several times the usual error, and tracks that too few views show then.
void DropUnusual(std::size_t min_views, RefineScene& scene) {
  constexpr double kMostTimesUsual = 5, kLeastPx = 0.5, kMostPx = 4;  // gate, and its limits. Guessed
  std::vector<double> errors;
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& seen : track.observations)
      errors.push_back(ReprojectionErrorPx(scene, track, seen));
  if (errors.empty()) return;
  const double most_px = std::clamp(kMostTimesUsual * Median(std::move(errors)), kLeastPx, kMostPx);
  for (SceneTrack& track : scene.tracks)
    std::erase_if(track.observations, [&](const TrackObservation& seen) {
      return !(ReprojectionErrorPx(scene, track, seen) <= most_px);
    });
  std::erase_if(scene.tracks, [&](const SceneTrack& track) { return track.observations.size() < min_views; });
}

}  // namespace

void MeasureAllTracks(const std::vector<PairMatches>& matched, RefineScene& scene) {
  const auto registered = std::count_if(scene.views.begin(), scene.views.end(),
                                        [](const RefineView& view) { return view.registered; });
  const int min_views = registered > 3 ? 3 : 2;
  constexpr int kAll = 1 << 20, kPerView = 4000;  // points a view. Guessed
  constexpr double kGatePx = 3;                   // guessed
  BuildTracks(matched, {.gate_px = kGatePx, .min_views = min_views, .per_view = kAll}, scene);
  FitPositions(scene);
  ExtendTracks({.per_view = kPerView}, scene);
  for (int round = 0; round < 2; ++round) {
    FitPositions(scene);
    DropUnusual(At(min_views), scene);
  }
  FitPositions(scene);
  std::erase_if(scene.tracks, [](const SceneTrack& track) { return track.observations.empty(); });
}

std::vector<ScenePoint> PointsOf(const RefineScene& scene, const std::vector<CameraModel>& cameras) {
  std::vector<ScenePoint> points;
  for (const SceneTrack& track : scene.tracks) {
    ScenePoint& point = points.emplace_back();
    point.position_in_world = track.position;
    point.rgb = track.rgb;
    for (const TrackObservation& seen : track.observations) {
      const RefineView& view = scene.view(seen.view);
      const CameraModel &working = scene.LensOf(view), &given = cameras[At(view.lens)];
      const Eigen::Vector2d to_given(static_cast<double>(given.width) / working.width,
                                     static_cast<double>(given.height) / working.height);
      point.track.push_back({seen.view, seen.img.cwiseProduct(to_given)});
      point.error_px += ReprojectionErrorPx(scene, track, seen) * to_given.mean();
    }
    point.error_px /= static_cast<double>(point.track.size());
  }
  return points;
}

TriangulationResult TriangulateViews(const RefineInput& input, const TriangulationOptions& options) {
  TriangulationResult result;
  const RefineStage reading{options.progress, 0, 0.3}, matching{options.progress, 0.3, 0.7},
      measuring{options.progress, 0.7, 1};
  constexpr int kManyCorners = 4000, kCorners = 2500;  // a view. Guessed
  const int features = options.features > 0              ? options.features
                       : input.views.size() <= kFewViews ? kManyCorners
                                                         : kCorners;
  RefineScene scene = ReadScene(input, options.max_side_px, features, reading);
  for (const RefineView& view : scene.views)
    if (!view.registered) result.unread.push_back(view.why);
  const std::vector<std::pair<int, int>> pairs = ChoosePairs(scene);
  // The poses are given and stay, even where the images disagree: always search along their epipolar lines.
  const double error_px = MeasurePoseErrorPx(scene, pairs).value_or(0);
  result.pose_error_px = error_px;
  const std::vector<PairMatches> matched =
      MatchPairs(scene, pairs, std::min(error_px, 0.99 * kGuidingErrorPx), matching);
  measuring.Show(0, "measuring all points");
  MeasureAllTracks(matched, scene);
  result.points = PointsOf(scene, input.lenses);
  return result;
}

}  // namespace ulf::tracking
