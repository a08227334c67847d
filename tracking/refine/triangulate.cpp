#include "tracking/refine/triangulate.h"

#include <algorithm>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/light_field/points/point_tracks.h"
#include "tracking/refine/track_building.h"
#include "tracking/refine/view_matching.h"

namespace ulf::tracking {
namespace {

// Corners of each of few views (kFewViews), which can afford more, and of each of many. Guessed.
constexpr int kTriangulationCornersOfFew = 4000, kTriangulationCornersOfMany = 2500;

constexpr double kAllTracksGatePx = 3;   // of triangulation, under poses that stay. Guessed
constexpr int kAllTracksPerView = 4000;  // points a view, about: more cost time. Guessed
// Observations are dropped that are off by so many times the usual error, within these limits. Guessed.
constexpr double kAllTracksMostTimesUsual = 5, kAllTracksLeastPx = 0.5, kAllTracksMostPx = 4;

// A track that fits nowhere loses all of them.
void FitPositions(RefineScene& scene) {
  ParallelFor(scene.tracks.size(), [&](std::size_t t) {
    SceneTrack& track = scene.tracks[t];
    std::vector<PosedObservation> observations;
    for (const TrackObservation& seen : track.observations) {
      const RefineView& view = scene.view(seen.view);
      observations.push_back({&scene.LensOf(view), &view.cam_from_world, seen.img});
    }
    if (const auto position = FitPoint(observations))
      track.position = *position;
    else
      track.observations.clear();
  });
}

// Drops observations that are off by several times the usual error, and tracks that too few views show then.
void DropUnusual(int min_views, RefineScene& scene) {
  std::vector<double> errors;
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& seen : track.observations)
      errors.push_back(ReprojectionErrorPx(scene, track, seen));
  if (errors.empty()) return;
  const double most_px =
      std::clamp(kAllTracksMostTimesUsual * Median(std::move(errors)), kAllTracksLeastPx, kAllTracksMostPx);
  for (SceneTrack& track : scene.tracks)
    std::erase_if(track.observations, [&](const TrackObservation& seen) {
      return !(ReprojectionErrorPx(scene, track, seen) <= most_px);
    });
  scene.DropShortTracks(min_views);
}

}  // namespace

void MeasureAllTracks(const std::vector<PairMatches>& matched, RefineScene& scene) {
  constexpr int kUnlimited = 1 << 20;  // points a view
  const int min_views = scene.MinViews();
  BuildTracks(matched, {.gate_px = kAllTracksGatePx, .min_views = min_views, .per_view = kUnlimited}, scene);
  FitPositions(scene);
  ExtendTracks(kAllTracksPerView, scene);
  for (int round = 0; round < 2; ++round) {
    FitPositions(scene);
    DropUnusual(min_views, scene);
  }
  FitPositions(scene);
  scene.DropShortTracks(1);
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
  const int by_number =
      input.views.size() <= kFewViews ? kTriangulationCornersOfFew : kTriangulationCornersOfMany;
  const int corners = options.features > 0 ? options.features : by_number;
  RefineScene scene = ReadScene(input, {.max_side_px = options.max_side_px, .corners = corners}, reading);
  for (const RefineView& view : scene.views)
    if (!view.registered) result.unread.push_back(view.why);
  const std::vector<std::pair<int, int>> pairs = ChoosePairs(scene);
  result.pose_error_px = MeasurePoseErrorPx(scene, pairs).value_or(0);
  // The poses stay, even where the images disagree: always search along their epipolar lines.
  constexpr double kGuides = 0.99 * kGuidingErrorPx;
  const std::vector<PairMatches> matched =
      MatchPairs(scene, pairs, std::min(result.pose_error_px, kGuides), matching);
  measuring.Show(0, "measuring all points");
  MeasureAllTracks(matched, scene);
  result.points = PointsOf(scene, input.lenses);
  return result;
}

}  // namespace ulf::tracking
