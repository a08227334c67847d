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
#include "tracking/refine/triangulate.h"
#include "tracking/refine/view_matching.h"

namespace ulf::tracking {
namespace {

// Corners of each of few views (kFewViews), which need more, and of each of many; points a view of few, of
// many, and while poses are rough. More cost time. Guessed.
constexpr int kRefineCornersOfFew = 4000, kRefineCornersOfMany = 1500;
constexpr int kRefinePerViewOfFew = 1500, kRefinePerView = 500, kRefinePerViewRoughly = 400;
constexpr int kRefineMinViewPoints = 20;  // a view with fewer points is not registered. Guessed
// the matches of fewer pairs are too few to compare the views. Guessed
constexpr int kRefineMinPairs = 10;
// Relative change of the cost that ends all adjustments but the last ones, for which they are starts and
// need not reach their minimum. Guessed.
constexpr double kRefineRoughTolerance = 1e-4;
// With RefineOptions::intrinsics a step of the lens that moves no point of the reduced image by more needs no
// other pass; passes, at most. Guessed.
constexpr double kRefineSettledLensPx = 0.5;
constexpr int kRefineMostPasses = 6;
// A view registered again: best descriptor distance / second best of a match. Guessed.
constexpr double kRefineMaxRatio = 0.85;
// A view that keeps a smaller share of its observations is contradicted by most of them.
constexpr double kRefineContradictedShare = 0.5;

void RequireReadable(const RefineScene& scene) {
  if (scene.Registered() >= 2) return;
  const auto unread =
      std::ranges::find_if(scene.views, [](const RefineView& view) { return !view.registered; });
  throw Error("{} of {} can be read{}; refining needs at least two", scene.Registered(),
              Counted(scene.views.size(), "view"),
              unread != scene.views.end() ? " (" + unread->why + ")" : "");
}

// Describes how an adjustment treats outliers; the better the start poses, the later in the list.
enum class Loss { kHuber, kCauchy, kCauchyAndGate };

BundleOptions LastAdjustment() {
  return {.robust_iterations = kLaterIterations,
          .iterations = kLaterIterations,
          .cauchy_scales = kSettledCauchyScales,
          .gate_scales = kSettledGateScales};
}

BundleSummary Adjust(RefineScene& scene, int iterations, Loss loss, const RefineStage& stage,
                     const char* what) {
  BundleProblem problem = ToBundle(scene);
  BundleOptions options;
  options.robust_iterations = options.iterations = iterations;
  options.cauchy_scales = loss != Loss::kHuber ? kSettledCauchyScales : 0;
  options.gate_scales = loss == Loss::kCauchyAndGate ? kSettledGateScales : 0;
  if (loss != Loss::kCauchyAndGate) options.function_tolerance = kRefineRoughTolerance;
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
  const bool few_tracks = scene.tracks.size() < At(kRefineMinViewPoints);
  if (alike < kRefineMinPairs * kMinPairMatches && few_tracks)
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
    if (!view.registered || seen[v] >= kRefineMinViewPoints) continue;
    std::vector<PointObservation> matches;
    for (const Feature& feature : view.features.all()) {
      NearestDescriptor nearest{-1, kSureDistance + 1, kSureDistance + 1};
      for (std::size_t d = 0; d < descriptors.size(); ++d)
        nearest.Offer(static_cast<int>(d), Distance(feature.descriptor, *descriptors[d]));
      if (nearest.index >= 0 && nearest.distance < kRefineMaxRatio * nearest.second)
        matches.push_back({owners[At(nearest.index)]->position, feature.img, DetectedSigmaPx(feature.level)});
    }
    const auto found =
        AbsolutePose(scene.LensOf(view), matches,
                     {.min_inliers = kRefineMinViewPoints, .seed = options.seed + static_cast<unsigned>(v)});
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

// Describes what the images say of a lens, pass by pass.
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

// The fits by lens of the input; none: the images say nothing of that lens.
using LensFits = std::vector<std::optional<LensFit>>;

// Weighs the evidence for each lens; takes the new lenses over on request.
void EstimateLenses(const RefineInput& input, const RefineOptions& options, bool is_first_pass,
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

// Returns how far another lens moves points of the image, at most; those without a ray, where distortion
// folds, tell nothing.
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

// Prepares another pass: every readable view takes part again, from where it is now.
void ResetScene(const std::vector<bool>& readable, RefineScene& scene) {
  scene.tracks.clear();
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (scene.views[v].registered || !readable[v]) continue;
    scene.views[v].registered = true;
    scene.views[v].why.clear();
  }
}

// A pass leads from the poses and lenses that the scene has to those that its images support.
struct Pass {
  double start_error_px = 0;  // of the working resolution
  BundleSummary summary;      // of the last adjustment
  std::vector<PairMatches> matched;
};

Pass RegisterAll(const RefineInput& input, const RefineOptions& options, const RefineStage& whole,
                 bool is_first_pass, RefineScene& scene, LensFits& fits, RefineResult& result) {
  const bool few = input.views.size() <= kFewViews;
  const int per_view = few ? kRefinePerViewOfFew : kRefinePerViewRoughly;
  const int extended_per_view = few ? kRefinePerViewOfFew : kRefinePerView;
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
    Adjust(scene, iterations, Loss::kHuber, first, "first adjustment");
  };
  const std::vector<std::pair<int, int>> pairs = ChoosePairs(scene);
  const double error_px = MeasurePoseErrorPx(scene, pairs).value_or(kMostStartErrorPx);
  pass.start_error_px = error_px;
  const bool guided = error_px < kGuidingErrorPx;
  build_tracks(pairs, error_px, std::max(kLeastGatePx, kGateErrors * error_px),
               guided ? per_view : kRefinePerViewRoughly);
  spdlog::debug("start poses off by {:.2f} px, {} pairs, {} points", error_px, pairs.size(),
                scene.tracks.size());
  adjust_first(guided ? kGuidedIterations : kUnguidedIterations);
  if (!guided) {
    // Now the poses guide the matching: it finds more, and wrong matches go.
    RegisterAgain(options, scene);
    for (const double now_px : {1.0, 0.5}) {
      build_tracks(ChoosePairs(scene), now_px, kRepeatedGateErrors * now_px,
                   now_px < 1 ? per_view : kRefinePerViewRoughly);
      adjust_first(kRepeatedIterations);
    }
  }
  RegisterAgain(options, scene);
  for (const RefineStage& stage : {whole.Part(0.5, 2.0 / 3), whole.Part(2.0 / 3, 0.8)}) {
    stage.Show(0, "looking for points in all views");
    ExtendTracks(extended_per_view, scene);
    Adjust(scene, kLaterIterations, Loss::kCauchy, stage, "adjustment");
  }
  DropUnsupported(kRefineMinViewPoints, scene);
  if (scene.Registered() < 2) throw Error("no two views agree; check that the poses belong to these images");
  const RefineStage lens = whole.Part(0.8, 0.9), last = whole.Part(0.9, 1);
  lens.Show(0, "weighing the lens");
  const std::vector<CameraModel> before = scene.lenses;
  EstimateLenses(input, options, is_first_pass, scene, fits, result);
  // Drop wrong observations only under the final lens: under a wrong lens right observations look wrong.
  if (scene.lenses != before)
    Adjust(scene, kLaterIterations, Loss::kCauchy, lens, "adjustment with the new lens");
  for (int round = 0; round < 2; ++round) {
    DropSlidingPoints(scene);
    pass.summary = Adjust(scene, kLaterIterations, Loss::kCauchyAndGate, last, "last adjustment");
  }
  DropUnsupported(kRefineMinViewPoints, scene);
  return pass;
}

}  // namespace

RefineResult Refine(const RefineInput& input, const RefineOptions& options) {
  RefineResult result;
  result.lenses = input.lenses;
  const bool few = input.views.size() <= kFewViews;
  const int by_number = few ? kRefineCornersOfFew : kRefineCornersOfMany;
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
  for (int count = 0; count < kRefineMostPasses && !lens_settled; ++count) {
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
      lens_settled = !options.intrinsics || LargestChangePx(given, scene.lenses) < kRefineSettledLensPx;
      continue;
    }
    // What the pass before reached stands until this one is better.
    RefineScene next = scene;
    LensFits next_fits = fits;
    RefineResult next_result = result;
    ResetScene(readable, next);
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
    lens_settled = LargestChangePx(scene.lenses, next.lenses) < kRefineSettledLensPx;
    scene = std::move(next);
    fits = std::move(next_fits);
    result = std::move(next_result);
  }
  for (std::size_t lens = 0; lens < fits.size(); ++lens)
    if (fits[lens]) result.lens_fits.emplace(static_cast<int>(lens), fits[lens]->Widened());
  if (pass.summary.least_kept < kRefineContradictedShare)
    result.contradicted = pass.summary.least_kept_camera;
  result.rms_after_sigmas = pass.summary.final_rms_sigmas;
  if (input.readout_s != 0) {
    const BundleSummary rows = AdjustRows(input, LastAdjustment(), scene);
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
    MeasureAllTracks(pass.matched, scene);
  }
  result.points = PointsOf(scene, input.lenses);
  return result;
}

}  // namespace ulf::tracking
