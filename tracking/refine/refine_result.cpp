#include "tracking/refine/refine_result.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/bundle_uncertainty.h"
#include "tracking/map/pose_error.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {
namespace {

// Views whose uncertainty is predicted, at most: the work grows with their third power.
constexpr int kMostUncertaintyViews = 200;

struct Errors {
  double rms = 0, median = 0;
};

// Errors of the tracks under the present poses, or of tracks fitted anew under the start poses; pixels of the
// given images, whose cameras are `given`.
Errors ErrorsUnder(const RefineScene& scene, const std::vector<CameraModel>& given, bool start) {
  constexpr double kMostPx = 1e3;  // of an error: also where a point does not project
  std::vector<double> errors;
  double squared = 0;
  for (const SceneTrack& track : scene.tracks) {
    Eigen::Vector3d position = track.position;
    if (start) {
      std::vector<RayObservation> rays;
      for (const TrackObservation& o : track.observations) {
        const RefineView& view = scene.view(o.view);
        if (const auto ray = scene.LensOf(view).RayFromImg(o.img)) rays.push_back({view.start, *ray});
      }
      position = TriangulatePoint(rays).value_or(position);
    }
    for (const TrackObservation& o : track.observations) {
      const RefineView& view = scene.view(o.view);
      const CameraModel& lens = scene.LensOf(view);
      const auto img = lens.ImgFromCam((start ? view.start : view.cam_from_world) * position);
      const double off_px = img ? std::min(kMostPx, (*img - o.img).norm()) : kMostPx;
      errors.push_back(GivenByWorking(given[At(view.lens)], lens) * off_px);
      squared += errors.back() * errors.back();
    }
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, errors.size()));
  return {std::sqrt(squared / count), Median(std::move(errors))};
}

void DescribeMoves(const RefineScene& scene, RefineResult& result) {
  std::vector<double> moved, turned;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const RefineView& view = scene.views[v];
    if (!view.registered || !view.is_recorded) continue;
    moved.push_back((view.cam_from_world.OriginInSource() - view.start.OriginInSource()).norm());
    turned.push_back(Degrees(RotationAngle(view.cam_from_world.rotation * view.start.rotation.conjugate())));
    if (moved.back() >= result.moved_max) {
      result.moved_max = moved.back();
      result.moved_most = static_cast<int>(v);
    }
    result.turned_max_deg = std::max(result.turned_max_deg, turned.back());
  }
  result.moved_median = Median(std::move(moved));
  result.turned_median_deg = Median(std::move(turned));
}

void DescribeCertainty(const RefineScene& scene, RefineResult& result) {
  if (result.groups > 1 || scene.Registered() > kMostUncertaintyViews) return;
  const std::vector<double> sigmas = CenterSigmas(scene.lenses, ToBundle(scene));
  std::vector<double> registered;
  for (std::size_t v = 0; v < sigmas.size(); ++v) {
    if (!scene.views[v].registered || std::isnan(sigmas[v])) continue;
    registered.push_back(sigmas[v]);
    if (result.center_sigma_max && sigmas[v] <= *result.center_sigma_max) continue;
    result.center_sigma_max = sigmas[v];
    result.least_sure = static_cast<int>(v);
  }
  if (!registered.empty()) result.center_sigma_median = Median(std::move(registered));
}

// Returns how sure the pose of a view is that came without one, from the points that it shows.
double QualityOfView(const RefineScene& scene, int index) {
  const RefineView& view = scene.view(index);
  std::vector<PointObservation> seen;
  std::vector<double> distances;
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations)
      if (o.view == index) {
        seen.push_back({track.position, o.img, o.sigma_px});
        distances.push_back((view.cam_from_world * track.position).norm());
      }
  const auto pose = RefinePose(scene.LensOf(view), seen, view.cam_from_world);
  return pose ? QualityOf(pose->center_sigma, Median(std::move(distances))) : 0;
}

}  // namespace

RefineResult Summarise(const RefineScene& scene, RefineResult result) {
  const std::vector<int> seen = PointsByView(scene);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const RefineView& view = scene.views[v];
    const double quality =
        view.registered && !view.is_recorded ? QualityOfView(scene, static_cast<int>(v)) : 1;
    result.views.push_back(
        {view.cam_from_world, view.registered, view.why, seen[v], quality, view.middle_row_from_picture});
  }
  result.registered = scene.Registered();
  for (const SceneTrack& track : scene.tracks) result.adjusted_observations += track.observations.size();
  result.adjusted_points = scene.tracks.size();
  const Errors before = ErrorsUnder(scene, result.lenses, true),
               after = ErrorsUnder(scene, result.lenses, false);
  result.rms_before_px = before.rms;
  result.median_before_px = before.median;
  result.rms_after_px = after.rms;
  result.median_after_px = after.median;
  DescribeMoves(scene, result);
  DescribeCertainty(scene, result);
  return result;
}

}  // namespace ulf::tracking
