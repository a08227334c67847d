#include "tracking/refine/refine.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/bundle_uncertainty.h"
#include "tracking/map/map.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/track_building.h"
#include "tracking/refine/track_extension.h"
#include "tracking/refine/triangulate.h"
#include "tracking/refine/view_matching.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

constexpr double kMostErrorPx = 40;
constexpr int kMinViewPoints = 20;
// Of settled poses, in units of the errors' own scale: where the loss begins to doubt, and where an
// observation is wrong (of errors that are normal 0.03 % are that far off).
constexpr double kDoubtAtScales = 2;
constexpr double kWrongAtScales = 4;

int Registered(const RefineScene& scene) {
  return static_cast<int>(std::count_if(scene.views.begin(), scene.views.end(),
                                        [](const RefineView& view) { return view.registered; }));
}

void RequireReadable(const RefineScene& scene) {
  if (Registered(scene) >= 2) return;
  std::string why;
  for (const RefineView& view : scene.views)
    if (!view.registered && why.empty()) why = " (" + view.why + ")";
  throw Error("{} of {} can be read{}; refining needs at least two", Registered(scene),
              Counted(scene.views.size(), "view"), why);
}

int MinViews(const RefineScene& scene) { return Registered(scene) > 3 ? 3 : 2; }

// What does not fit is, the better the poses: asked again later, doubted, wrong.
enum class Unfit { kOutlier, kDoubtful, kWrong };

BundleSummary Adjust(RefineScene& scene, int iterations, Unfit unfit, const RefineStage& stage,
                     const char* what) {
  BundleProblem problem = ToBundle(scene);
  BundleOptions options;
  options.robust_iterations = options.iterations = iterations;
  options.cauchy_scales = unfit != Unfit::kOutlier ? kDoubtAtScales : 0;
  options.gate_scales = unfit == Unfit::kWrong ? kWrongAtScales : 0;
  // What comes before is a start for the last one: it need not be at its minimum.
  options.function_tolerance = unfit == Unfit::kWrong ? 1e-5 : 1e-4;
  options.progress = [&](int count) {
    stage.Show(std::min(1.0, 0.5 * count / iterations),
               fmt::format("{}, {} observations, iteration {}", what, problem.observations.size(), count));
  };
  std::vector<CameraModel> lenses = scene.lenses;
  const BundleSummary summary = AdjustBundle(lenses, problem, options);
  if (!summary.usable)
    throw Error("the adjustment failed ({}); check that the poses belong to these images", summary.message);
  FromBundle(problem, MinViews(scene), scene);
  spdlog::debug("{}: {} points, {} observations, {:.3f} -> {:.3f} sigmas, {} outliers, {} iterations", what,
                scene.tracks.size(), problem.observations.size(), summary.initial_rms_sigmas,
                summary.final_rms_sigmas, summary.outliers, summary.iterations);
  return summary;
}

std::vector<int> PointsByView(const RefineScene& scene) {
  std::vector<int> count(scene.views.size(), 0);
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations) ++count[static_cast<std::size_t>(o.view)];
  return count;
}

void RequireParallax(const RefineScene& scene, const std::vector<PairMatches>& matched, unsigned seed) {
  int alike = 0;
  for (const PairMatches& pair : matched) alike += pair.alike;
  if (alike < 10 * kMinPairMatches && scene.tracks.size() < static_cast<std::size_t>(kMinViewPoints))
    throw Error(
        "the views share too little to compare them ({} look alike); check that they show one scene and that "
        "the poses belong to them",
        Counted(alike, "corner"));
  if (scene.tracks.size() < static_cast<std::size_t>(kMinViewPoints) || IsOnePlace(scene, matched, seed))
    throw Error(
        "{} look alike, but there is no parallax: views taken by turning about one place cannot be refined, "
        "nor from poses that are far from true",
        Counted(alike, "corner"));
}

// Views that show too few points: once more from nothing, by what the points look like.
void RegisterAgain(RefineScene& scene, unsigned seed) {
  const std::vector<int> seen = PointsByView(scene);
  std::vector<const Descriptor*> descriptors;
  std::vector<const SceneTrack*> owners;
  for (const SceneTrack& track : scene.tracks)
    for (const TrackObservation& o : track.observations)
      if (o.feature >= 0) {
        descriptors.push_back(&scene.view(o.view).features[o.feature].descriptor);
        owners.push_back(&track);
        break;
      }
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    RefineView& view = scene.views[v];
    if (!view.registered || seen[v] >= kMinViewPoints) continue;
    std::vector<PointObservation> matches;
    for (const Feature& feature : view.features.all()) {
      int best = kSureDistance + 1, second = 257;
      std::size_t owner = 0;
      for (std::size_t d = 0; d < descriptors.size(); ++d) {
        const int distance = Distance(feature.descriptor, *descriptors[d]);
        if (distance < best) {
          second = best;
          best = distance;
          owner = d;
        } else {
          second = std::min(second, distance);
        }
      }
      if (best <= kSureDistance && best < 0.85 * second)
        matches.push_back({owners[owner]->position, feature.img, DetectedSigmaPx(feature.level)});
    }
    const auto found = AbsolutePose(scene.LensOf(view), matches,
                                    {.min_inliers = kMinViewPoints, .seed = seed + static_cast<unsigned>(v)});
    if (found) {
      view.cam_from_world = found->cam_from_world;
      spdlog::debug("{}: registered again with {} points", view.name, found->inliers.size());
    } else {
      view.registered = false;
      view.why = fmt::format("shows {} of the points that the other views share, too few to place it",
                             Counted(seen[v], "point"));
      view.cam_from_world = view.start;
    }
  }
}

// Takes the observations of views that show too little out of the world.
void DropUnsupported(RefineScene& scene) {
  for (bool dropped = true; dropped;) {
    dropped = false;
    const std::vector<int> seen = PointsByView(scene);
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      RefineView& view = scene.views[v];
      if (view.registered && seen[v] < kMinViewPoints) {
        view.registered = false;
        view.why = fmt::format("only {} of the others' points agree with it", seen[v]);
        dropped = true;
      }
    }
    for (SceneTrack& track : scene.tracks)
      std::erase_if(track.observations,
                    [&](const TrackObservation& o) { return !scene.view(o.view).registered; });
    std::erase_if(scene.tracks, [&](const SceneTrack& track) {
      return static_cast<int>(track.observations.size()) < MinViews(scene);
    });
  }
  for (RefineView& view : scene.views)
    if (!view.registered) view.cam_from_world = view.start;
}

struct Errors {
  double rms = 0, median = 0;
};

// What a pixel of the working resolution is in pixels of the pictures as they were given.
double GivenByWorking(const CameraModel& given, const CameraModel& working) {
  return static_cast<double>(given.width + given.height) / (working.width + working.height);
}

// In pixels of the pictures as they were given, whose cameras are `given`.
Errors ErrorsUnder(const RefineScene& scene, const std::vector<CameraModel>& given, bool start) {
  RefineScene at;
  at.lenses = scene.lenses;
  for (const RefineView& view : scene.views) {
    RefineView& copy = at.views.emplace_back();
    copy.lens = view.lens;
    copy.cam_from_world = start ? view.start : view.cam_from_world;
  }
  std::vector<double> errors;
  double squared = 0;
  for (SceneTrack track : scene.tracks) {
    if (start) {
      std::vector<RayObservation> rays;
      for (const TrackObservation& o : track.observations) {
        const RefineView& view = at.view(o.view);
        if (const auto ray = at.LensOf(view).RayFromImg(o.img)) rays.push_back({view.cam_from_world, *ray});
      }
      if (const auto point = TriangulatePoint(rays)) track.position = *point;
    }
    for (const TrackObservation& o : track.observations) {
      const auto lens = static_cast<std::size_t>(at.view(o.view).lens);
      const double error =
          GivenByWorking(given[lens], scene.lenses[lens]) * std::min(1e3, ReprojectionErrorPx(at, track, o));
      errors.push_back(error);
      squared += error * error;
    }
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, errors.size()));
  return {std::sqrt(squared / count), Median(std::move(errors))};
}

void DescribeMoves(const RefineScene& scene, RefineResult& result) {
  std::vector<double> moved, turned;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const RefineView& view = scene.views[v];
    if (!view.registered) continue;
    moved.push_back((view.cam_from_world.OriginInSource() - view.start.OriginInSource()).norm());
    turned.push_back(RotationAngle(view.cam_from_world.rotation * view.start.rotation.conjugate()) * 180 /
                     M_PI);
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
  constexpr int kMostViews = 200;  // the work grows with their third power
  if (result.groups > 1 || Registered(scene) > kMostViews) return;
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

// What the pictures say about each lens; taken over where asked for.
void WeighLenses(const RefineInput& input, const RefineOptions& options, RefineScene& scene,
                 RefineResult& result) {
  const BundleProblem problem = ToBundle(scene);
  for (int l = 0; l < static_cast<int>(scene.lenses.size()); ++l) {
    CameraModel& working = scene.lenses[static_cast<std::size_t>(l)];
    const CameraModel& given = input.lenses[static_cast<std::size_t>(l)];
    const double to_given = GivenByWorking(given, working);
    if (const auto check = CheckCalibration(working, problem, l)) result.checks.push_back(check->Of(given));
    const auto fit = ChooseLens(working, PartForLens(problem, l), {}, &result.lens_trials.emplace_back());
    if (!fit) continue;
    LensEstimate scaled = *fit;
    scaled.lens = fit->lens.ScaledTo(given.width, given.height);
    scaled.focal_sigma_px *= to_given;
    scaled.principal_point_sigma_px *= to_given;
    result.lens_fits.push_back(scaled);
    if (!options.intrinsics) continue;
    working = fit->lens;
    result.lenses[static_cast<std::size_t>(l)] = scaled.lens;
  }
}

RefineResult Summarise(const RefineScene& scene, RefineResult result) {
  const std::vector<int> seen = PointsByView(scene);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const RefineView& view = scene.views[v];
    result.views.push_back({view.cam_from_world, view.registered, view.why, seen[v]});
  }
  result.registered = Registered(scene);
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

}  // namespace

RefineResult Refine(const RefineInput& input, const RefineOptions& options) {
  RefineResult result;
  result.lenses = input.lenses;
  RefineScene scene = SceneOf(input, options.max_side_px);
  const RefineStage reading{options.progress, 0, 0.3}, matching{options.progress, 0.3, 0.5};
  // Few views can afford more corners, and need them.
  const bool few = input.views.size() <= 100;
  const int features = options.features > 0 ? options.features : few ? 4000 : 1500;
  // Points a view: few views need more of them; while poses are far off fewer will do.
  constexpr int kRoughly = 400;
  const int per_view = few ? 1500 : kRoughly;
  const ExtensionOptions extension{.per_view = few ? 1500 : 500};
  ReadViews({input.read, features,
             [&](int done) {
               reading.Show(static_cast<double>(done) / static_cast<double>(input.views.size()),
                            fmt::format("reading view {}", done));
             }},
            scene);
  RequireReadable(scene);

  std::vector<std::pair<int, int>> pairs = ChoosePairs(scene);
  const auto start_error_px = MeasurePoseErrorPx(scene, pairs);
  // Where hardly anything matches without knowing where to look: as bad as may be.
  const double error_px = start_error_px.value_or(kMostErrorPx);
  std::vector<double> given_by_working;
  for (const RefineView& view : scene.views)
    given_by_working.push_back(
        GivenByWorking(input.lenses[static_cast<std::size_t>(view.lens)], scene.LensOf(view)));
  result.start_error_px = error_px * Median(std::move(given_by_working));
  const bool guided = error_px < kGuidingErrorPx;
  std::vector<PairMatches> matched = MatchPairs(scene, pairs, error_px, matching);
  BuildTracks(matched,
              {.gate_px = std::max(4.0, 6 * error_px),
               .min_views = MinViews(scene),
               .per_view = guided ? per_view : kRoughly},
              scene);
  spdlog::debug("start poses off by {:.2f} px, {} pairs, {} points", error_px, pairs.size(),
                scene.tracks.size());
  RequireParallax(scene, matched, options.seed);
  Adjust(scene, guided ? 10 : 60, Unfit::kOutlier, {options.progress, 0.5, 0.6}, "first adjustment");
  if (!guided) {
    // Now the poses can guide: more is found, and what was wrong goes.
    RegisterAgain(scene, options.seed);
    for (const double now_px : {1.0, 0.5}) {
      pairs = ChoosePairs(scene);
      matched = MatchPairs(scene, pairs, now_px, matching);
      BuildTracks(
          matched,
          {.gate_px = 8 * now_px, .min_views = MinViews(scene), .per_view = now_px < 1 ? per_view : kRoughly},
          scene);
      RequireParallax(scene, matched, options.seed);
      Adjust(scene, 30, Unfit::kOutlier, {options.progress, 0.5, 0.6}, "first adjustment");
    }
  }
  RegisterAgain(scene, options.seed);
  BundleSummary summary;
  for (const RefineStage stage :
       {RefineStage{options.progress, 0.6, 0.7}, RefineStage{options.progress, 0.7, 0.8}}) {
    stage.Show(0, "looking for points in all views");
    ExtendTracks(extension, scene);
    Adjust(scene, 12, Unfit::kDoubtful, stage, "adjustment");
  }
  DropUnsupported(scene);
  if (Registered(scene) < 2) throw Error("no two views agree; check that the poses belong to these images");
  const RefineStage lens{options.progress, 0.8, 0.85}, last{options.progress, 0.85, 0.9};
  lens.Show(0, "weighing the lens");
  WeighLenses(input, options, scene, result);
  // Only under the lens that is kept: what contradicts a wrong one would look wrong itself.
  if (result.lenses != input.lenses)
    Adjust(scene, 12, Unfit::kDoubtful, lens, "adjustment with the new lens");
  for (int round = 0; round < 2; ++round) {
    DropSliding(scene);
    summary = Adjust(scene, 12, Unfit::kWrong, last, "last adjustment");
  }
  DropUnsupported(scene);
  if (summary.least_kept < 0.5) result.contradicted = summary.least_kept_camera;
  result.rms_after_sigmas = summary.final_rms_sigmas;
  result.settled = summary.settled;
  result.groups = GroupViews(scene).count;
  if (!AlignToStart(scene))
    throw Error("the views' positions do not determine a scale; give poses that differ");
  result = Summarise(scene, std::move(result));
  if (options.all_points) {
    const RefineStage all{options.progress, 0.9, 1};
    all.Show(0, "measuring all points");
    MeasureAllTracks(matched, scene);
  }
  result.points = PointsOf(scene, input.lenses);
  return result;
}

}  // namespace ulf::tracking
