#include "tracking/refine/refine_rows.h"

#include "core/base/at.h"
#include "core/base/quantile.h"

namespace ulf::tracking {
namespace {

// One standard deviation of a recorded velocity: of a trembling hand, radians and median depths per second,
// and as a share of the velocity. The tracker's map has the same values (map_adjustment.cpp).
constexpr double kRowsTremorTurn = 0.01, kRowsTremorShift = 0.003, kRowsVelocityShare = 0.1;
// One standard deviation of the velocity of a view without a recorded one, radians and median depths per
// second. Guessed.
constexpr double kRowsUnknown = 0.3;

// Median depth of the points that each view shows.
std::vector<double> DepthsByView(const RefineScene& scene) {
  std::vector<std::vector<double>> depths(scene.views.size());
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations)
      depths[At(o.view)].push_back((scene.view(o.view).cam_from_world * track.position).z());
  std::vector<double> medians;
  for (std::vector<double>& of_view : depths) medians.push_back(Median(std::move(of_view)));
  return medians;
}

RowsMotion MotionOf(const std::optional<Twist>& recorded, double depth) {
  RowsMotion motion;
  double turn = kRowsUnknown, shift = kRowsUnknown * depth;
  if (recorded) {
    motion.twist = motion.prior = *recorded;
    turn = std::hypot(kRowsTremorTurn, kRowsVelocityShare * recorded->head<3>().norm());
    shift = std::hypot(kRowsTremorShift * depth, kRowsVelocityShare * recorded->tail<3>().norm());
  }
  motion.prior_sigma << Eigen::Vector3d::Constant(turn), Eigen::Vector3d::Constant(shift);
  return motion;
}

}  // namespace

BundleSummary AdjustRows(const RefineInput& input, const BundleOptions& options, RefineScene& scene) {
  BundleProblem problem = ToBundle(scene);
  problem.readout_s = input.readout_s;
  const std::vector<double> depths = DepthsByView(scene);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    problem.rows.push_back(depths[v] > 0 ? std::optional(MotionOf(input.views[v].twist, depths[v]))
                                         : std::nullopt);
  std::vector<Rigid3> pictures;
  for (const RefineView& view : scene.views) pictures.push_back(view.cam_from_world);
  std::vector<CameraModel> lenses = scene.lenses;
  const BundleSummary summary = AdjustBundle(lenses, problem, options);
  if (!summary.usable) return summary;
  FromBundle(problem, scene.MinViews(), scene);
  std::vector<std::vector<PointObservation>> seen(scene.views.size());
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations)
      seen[At(o.view)].push_back({track.position, o.img, 1});
  // Users of the picture know neither rows nor how sure a corner is: all weigh the same, and none is an
  // outlier because the rows displace it.
  constexpr RefinePoseOptions kAllAlike{.huber_sigmas = 1e3, .gate_sigmas = 1e3, .rounds = 1};
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    RefineView& view = scene.views[v];
    if (!problem.rows[v]) continue;
    const auto picture = RefinePose(scene.LensOf(view), seen[v], view.cam_from_world, kAllAlike);
    if (!picture) {
      view.cam_from_world = pictures[v];
      continue;
    }
    view.middle_row_from_picture = view.cam_from_world * picture->cam_from_world.Inverse();
    view.cam_from_world = picture->cam_from_world;
  }
  return summary;
}

}  // namespace ulf::tracking
