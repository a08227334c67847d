#include "tracking/refine/refine.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/refine/refine_result.h"
#include "tracking/refine/refine_rows.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/track_building.h"
#include "tracking/refine/track_extension.h"
#include "tracking/refine/triangulate.h"
#include "tracking/refine/view_matching.h"

namespace ulf::tracking {
namespace {

void RequireReadable(const RefineScene& scene) {
  if (scene.Registered() >= 2) return;
  const auto unread = std::find_if(scene.views.begin(), scene.views.end(),
                                   [](const RefineView& view) { return !view.registered; });
  throw Error("{} of {} can be read{}; refining needs at least two", scene.Registered(),
              Counted(scene.views.size(), "view"),
              unread != scene.views.end() ? " (" + unread->why + ")" : "");
}

// How an adjustment treats observations that do not fit; the better the start poses, the later in the list.
enum class Loss { kHuber, kCauchy, kCauchyAndGate };

BundleOptions LastAdjustment(const RefineOptions& refine) {
  BundleOptions options;
  options.robust_iterations = options.iterations = refine.iterations;
  options.cauchy_scales = refine.cauchy_scales;
  options.gate_scales = refine.gate_scales;
  return options;
}

BundleSummary Adjust(const RefineOptions& refine, RefineScene& scene, int iterations, Loss loss,
                     const RefineStage& stage, const char* what) {
  BundleProblem problem = ToBundle(scene);
  BundleOptions options;
  options.robust_iterations = options.iterations = iterations;
  options.cauchy_scales = loss != Loss::kHuber ? refine.cauchy_scales : 0;
  options.gate_scales = loss == Loss::kCauchyAndGate ? refine.gate_scales : 0;
  if (loss != Loss::kCauchyAndGate) options.function_tolerance = refine.rough_tolerance;
  options.progress = [&](int count) {
    stage.Show(std::min(1.0, 0.5 * count / iterations),
               fmt::format("{}, {} observations, iteration {}", what, problem.observations.size(), count));
  };
  std::vector<CameraModel> lenses = scene.lenses;
  const BundleSummary summary = AdjustBundle(lenses, problem, options);
  if (!summary.usable)
    throw Error("the adjustment failed ({}); check that the poses belong to these images", summary.message);
  FromBundle(problem, scene.MinViews(), scene);
  spdlog::debug("{}: {} points, {} observations, {:.3f} -> {:.3f} sigmas, {} outliers, {} iterations", what,
                scene.tracks.size(), problem.observations.size(), summary.initial_rms_sigmas,
                summary.final_rms_sigmas, summary.outliers, summary.iterations);
  return summary;
}

void RequireParallax(const RefineScene& scene, const std::vector<PairMatches>& matched,
                     const RefineOptions& options) {
  int alike = 0;
  for (const PairMatches& pair : matched) alike += pair.alike;
  const bool few_tracks = scene.tracks.size() < At(options.min_view_points);
  if (alike < options.min_pairs * kMinPairMatches && few_tracks)
    throw Error(
        "the views share too little to compare them ({} look alike); check that they show one scene and that "
        "the poses belong to them",
        Counted(alike, "corner"));
  if (few_tracks || IsOnePlace(scene, matched, options.seed))
    throw Error(
        "{} look alike, but there is no parallax: views taken by turning about one place cannot be refined, "
        "nor can views whose poses are far from true",
        Counted(alike, "corner"));
}

// Registers views that show too few points again, from the points' descriptors alone.
void RegisterAgain(const RefineOptions& options, RefineScene& scene) {
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
    if (!view.registered || seen[v] >= options.min_view_points) continue;
    std::vector<PointObservation> matches;
    for (const Feature& feature : view.features.all()) {
      NearestDescriptor nearest{-1, kSureDistance + 1, kSureDistance + 1};
      for (std::size_t d = 0; d < descriptors.size(); ++d)
        nearest.Offer(static_cast<int>(d), Distance(feature.descriptor, *descriptors[d]));
      if (nearest.index >= 0 && nearest.distance < options.max_ratio * nearest.second)
        matches.push_back({owners[At(nearest.index)]->position, feature.img, DetectedSigmaPx(feature.level)});
    }
    const auto found = AbsolutePose(
        scene.LensOf(view), matches,
        {.min_inliers = options.min_view_points, .seed = options.seed + static_cast<unsigned>(v)});
    if (found) {
      view.cam_from_world = found->cam_from_world;
      spdlog::debug("{}: registered again with {} points", view.name, found->inliers.size());
    } else {
      view.registered = false;
      view.why = fmt::format("shows {} of the points that the other views share, too few for a pose",
                             Counted(seen[v], "point"));
      view.cam_from_world = view.start;
    }
  }
}

// Marks views with too few points as not registered and drops their observations.
void DropUnsupported(int min_view_points, RefineScene& scene) {
  for (bool dropped = true; dropped;) {
    dropped = false;
    const std::vector<int> seen = PointsByView(scene);
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      RefineView& view = scene.views[v];
      if (view.registered && seen[v] < min_view_points) {
        view.registered = false;
        view.why = fmt::format("only {} of the others' points agree with it", seen[v]);
        dropped = true;
      }
    }
    for (SceneTrack& track : scene.tracks)
      std::erase_if(track.observations,
                    [&](const TrackObservation& o) { return !scene.view(o.view).registered; });
    scene.DropShortTracks(scene.MinViews());
  }
  for (RefineView& view : scene.views)
    if (!view.registered) view.cam_from_world = view.start;
}

// What the images say of a lens, pass by pass.
struct LensFit {
  LensEstimate estimate;  // of all passes: what any of them freed, with the deviations of the last that did
  CameraModel before;     // the lens that the last pass began with; after the first the estimate's
  void GoOn(const LensEstimate& later);
  // A last step that is larger than a deviation counts as one.
  LensEstimate Widened() const;
};

void LensFit::GoOn(const LensEstimate& later) {
  estimate.lens = later.lens;
  const auto take = [](bool freed, double sigma, bool& free, double& total) {
    if (!freed) return;
    free = true;
    total = sigma;
  };
  take(later.free.focal, later.focal_sigma_px, estimate.free.focal, estimate.focal_sigma_px);
  take(later.free.principal_point, later.principal_point_sigma_px, estimate.free.principal_point,
       estimate.principal_point_sigma_px);
  take(later.free.k1, later.k1_sigma, estimate.free.k1, estimate.k1_sigma);
  take(later.free.k2, later.k2_sigma, estimate.free.k2, estimate.k2_sigma);
}

LensEstimate LensFit::Widened() const {
  LensEstimate widened = estimate;
  const CameraModel& now = estimate.lens;
  const auto widen = [](bool is_free, double step, double& sigma) {
    if (is_free) sigma = std::max(sigma, std::abs(step));
  };
  widen(widened.free.focal, now.MeanFocalPx() - before.MeanFocalPx(), widened.focal_sigma_px);
  widen(widened.free.principal_point, now.cx - before.cx, widened.principal_point_sigma_px);
  widen(widened.free.principal_point, now.cy - before.cy, widened.principal_point_sigma_px);
  widen(widened.free.k1, now.coefficients[0] - before.coefficients[0], widened.k1_sigma);
  widen(widened.free.k2, now.coefficients[1] - before.coefficients[1], widened.k2_sigma);
  return widened;
}

// Of each lens of the input.
using LensFits = std::vector<std::optional<LensFit>>;

// Weighs the evidence for each lens; takes the new lenses over on request.
void WeighLenses(const RefineInput& input, const RefineOptions& options, bool is_first_pass,
                 RefineScene& scene, LensFits& fits, RefineResult& result) {
  const BundleProblem problem = ToBundle(scene);
  fits.resize(scene.lenses.size());
  for (int l = 0; l < static_cast<int>(scene.lenses.size()); ++l) {
    CameraModel& working = scene.lenses[At(l)];
    const CameraModel& given = input.lenses[At(l)];
    const double to_given = GivenByWorking(given, working);
    std::vector<LensTrial> trials;
    const auto fit = ChooseLens(working, PartForLens(problem, l), {}, &trials);
    if (is_first_pass) {
      if (const auto check = CheckCalibration(working, problem, l)) result.checks.push_back(check->Of(given));
      result.lens_trials.push_back(std::move(trials));
    }
    std::optional<LensFit>& known = fits[At(l)];
    if (known) known->before = known->estimate.lens;
    if (!fit) continue;
    LensEstimate scaled = *fit;
    scaled.lens = fit->lens.ScaledTo(given.width, given.height);
    scaled.focal_sigma_px *= to_given;
    scaled.principal_point_sigma_px *= to_given;
    if (known)
      known->GoOn(scaled);
    else
      known = {scaled, is_first_pass ? scaled.lens : given};
    if (!options.intrinsics) continue;
    working = fit->lens;
    result.lenses[At(l)] = scaled.lens;
  }
}

// How far another lens moves points of the image, at most; those without a ray, where distortion folds, tell nothing.
double LensChangePx(const CameraModel& from, const CameraModel& to) {
  double most = 0;
  for (const double x : {0.0, 0.5, 1.0})
    for (const double y : {0.0, 0.5, 1.0}) {
      const Eigen::Vector2d img(x * from.width, y * from.height);
      const auto ray = from.RayFromImg(img);
      if (!ray) continue;
      const auto moved = to.ImgFromCam(*ray);
      most = std::max(most, moved ? (*moved - img).norm() : std::numeric_limits<double>::infinity());
    }
  return most;
}

double LargestChangePx(const std::vector<CameraModel>& from, const std::vector<CameraModel>& to) {
  double most = 0;
  for (std::size_t l = 0; l < from.size(); ++l) most = std::max(most, LensChangePx(from[l], to[l]));
  return most;
}

// For another pass: every readable view takes part again, from where it is now.
void StartAgain(const std::vector<bool>& readable, RefineScene& scene) {
  scene.tracks.clear();
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (scene.views[v].registered || !readable[v]) continue;
    scene.views[v].registered = true;
    scene.views[v].why.clear();
  }
}

// From the poses and lenses that the scene has to those that its images speak for.
struct Pass {
  double start_error_px = 0;  // of the working resolution
  BundleSummary summary;      // of the last adjustment
  std::vector<PairMatches> matched;
};

Pass RegisterAll(const RefineInput& input, const RefineOptions& options, const RefineStage& whole,
                 bool is_first_pass, RefineScene& scene, LensFits& fits, RefineResult& result) {
  const bool few = input.views.size() <= kFewViews;
  const int per_view = few ? options.per_view_of_few : options.per_view_roughly;
  const ExtensionOptions extension{.per_view = few ? options.per_view_of_few : options.per_view};
  const RefineStage matching = whole.Part(0, 1.0 / 3), first = whole.Part(1.0 / 3, 0.5);
  Pass pass;
  const auto build_tracks = [&](const std::vector<std::pair<int, int>>& pairs, double error_px,
                                double gate_px, int tracks_per_view) {
    pass.matched = MatchPairs(scene, pairs, error_px, matching);
    BuildTracks(pass.matched,
                {.gate_px = gate_px, .min_views = scene.MinViews(), .per_view = tracks_per_view}, scene);
  };
  const auto adjust_first = [&](int iterations) {
    RequireParallax(scene, pass.matched, options);
    Adjust(options, scene, iterations, Loss::kHuber, first, "first adjustment");
  };
  const std::vector<std::pair<int, int>> pairs = ChoosePairs(scene);
  const double error_px = MeasurePoseErrorPx(scene, pairs).value_or(options.most_error_px);
  pass.start_error_px = error_px;
  const bool guided = error_px < kGuidingErrorPx;
  build_tracks(pairs, error_px, std::max(options.least_gate_px, options.gate_errors * error_px),
               guided ? per_view : options.per_view_roughly);
  spdlog::debug("start poses off by {:.2f} px, {} pairs, {} points", error_px, pairs.size(),
                scene.tracks.size());
  adjust_first(guided ? options.guided_iterations : options.unguided_iterations);
  if (!guided) {
    // Now the poses guide the matching: it finds more, and wrong matches go.
    RegisterAgain(options, scene);
    for (const double now_px : {1.0, 0.5}) {
      build_tracks(ChoosePairs(scene), now_px, options.repeated_gate_errors * now_px,
                   now_px < 1 ? per_view : options.per_view_roughly);
      adjust_first(options.repeated_iterations);
    }
  }
  RegisterAgain(options, scene);
  for (const RefineStage& stage : {whole.Part(0.5, 2.0 / 3), whole.Part(2.0 / 3, 0.8)}) {
    stage.Show(0, "looking for points in all views");
    ExtendTracks(extension, scene);
    Adjust(options, scene, options.iterations, Loss::kCauchy, stage, "adjustment");
  }
  DropUnsupported(options.min_view_points, scene);
  if (scene.Registered() < 2) throw Error("no two views agree; check that the poses belong to these images");
  const RefineStage lens = whole.Part(0.8, 0.9), last = whole.Part(0.9, 1);
  lens.Show(0, "weighing the lens");
  const std::vector<CameraModel> before = scene.lenses;
  WeighLenses(input, options, is_first_pass, scene, fits, result);
  // Drop wrong observations only under the final lens: under a wrong lens right observations look wrong.
  if (scene.lenses != before)
    Adjust(options, scene, options.iterations, Loss::kCauchy, lens, "adjustment with the new lens");
  for (int round = 0; round < 2; ++round) {
    DropSliding(scene);
    pass.summary = Adjust(options, scene, options.iterations, Loss::kCauchyAndGate, last, "last adjustment");
  }
  DropUnsupported(options.min_view_points, scene);
  return pass;
}

}  // namespace

RefineResult Refine(const RefineInput& input, const RefineOptions& options) {
  RefineResult result;
  result.lenses = input.lenses;
  const bool few = input.views.size() <= kFewViews;
  const int by_number = few ? options.corners_of_few : options.corners;
  const int corners = options.features > 0 ? options.features : by_number;
  RefineScene scene =
      ReadScene(input, {.max_side_px = options.max_side_px, .corners = corners}, {options.progress, 0, 0.3});
  RequireReadable(scene);
  const std::vector<CameraModel> given = scene.lenses;
  std::vector<bool> readable;
  for (const RefineView& view : scene.views) readable.push_back(view.registered);

  LensFits fits;
  Pass pass;
  bool lens_settled = false;
  double done = 0.3;
  constexpr double kEnd = 0.9;
  for (int count = 0; count < options.most_passes && !lens_settled; ++count) {
    // Who takes over a lens may need another pass.
    const double until = options.intrinsics ? (done + kEnd) / 2 : kEnd;
    const RefineStage stage{options.progress, done, until};
    done = until;
    if (count == 0) {
      pass = RegisterAll(input, options, stage, true, scene, fits, result);
      std::vector<double> given_by_working;
      for (const RefineView& view : scene.views)
        given_by_working.push_back(GivenByWorking(input.lenses[At(view.lens)], scene.LensOf(view)));
      result.start_error_px = pass.start_error_px * Median(std::move(given_by_working));
      lens_settled = !options.intrinsics || LargestChangePx(given, scene.lenses) < options.settled_lens_px;
      continue;
    }
    // What the pass before reached stands until this one is better.
    RefineScene next = scene;
    LensFits next_fits = fits;
    RefineResult next_result = result;
    StartAgain(readable, next);
    std::string worse;
    try {
      Pass again = RegisterAll(input, options, stage, false, next, next_fits, next_result);
      if (next.Registered() < scene.Registered())
        worse = fmt::format("{} instead of {} views fit", next.Registered(), scene.Registered());
      else
        pass = std::move(again);
    } catch (const Error& error) {
      worse = error.what();
    }
    if (!worse.empty()) {
      spdlog::warn("under the lens that was found, registering again failed ({}): the result before stays",
                   worse);
      break;
    }
    lens_settled = LargestChangePx(scene.lenses, next.lenses) < options.settled_lens_px;
    scene = std::move(next);
    fits = std::move(next_fits);
    result = std::move(next_result);
  }
  for (std::size_t lens = 0; lens < fits.size(); ++lens)
    if (fits[lens]) result.lens_fits.emplace(static_cast<int>(lens), fits[lens]->Widened());
  if (pass.summary.least_kept < options.contradicted_share)
    result.contradicted = pass.summary.least_kept_camera;
  result.rms_after_sigmas = pass.summary.final_rms_sigmas;
  if (input.readout_s != 0) {
    const BundleSummary rows = AdjustRows(input, LastAdjustment(options), scene);
    if (!rows.usable)
      spdlog::warn("the adjustment that knows the shutter's rows failed ({}): poses are as without it",
                   rows.message);
  }
  result.settled = pass.summary.settled && lens_settled;
  DropGroupsWithoutRecordedViews(scene);
  result.groups = GroupViews(scene).count;
  if (!AlignToStart(scene))
    throw Error("the views' positions do not determine a scale; give poses that differ");
  result = Summarise(scene, std::move(result));
  if (options.all_points) {
    const RefineStage all{options.progress, kEnd, 1};
    all.Show(0, "measuring all points");
    MeasureAllTracks(pass.matched, {}, scene);
  }
  result.points = PointsOf(scene, input.lenses);
  return result;
}

}  // namespace ulf::tracking
