#include "tracking/refine/locate_photographs.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/parallel_for.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/features/matching.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/track_building.h"
#include "tracking/refine/view_matching.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {
namespace {

constexpr int kLocateCorners = 2000;  // a picture. Guessed
constexpr int kLocatePointsPerView = 1000;
// A photograph's pose is sought with the views that look most like it, and the matches that each of them
// needs at least. Guessed.
constexpr int kLocateBestViews = 10, kLocateMinMatches = 12;
constexpr int kLocateMinPoints = 25;  // that agree on a pose: fewer may do so by chance. Guessed

// A photograph that has no pose yet, and what it matches of the views that have one.
struct UnposedPhotograph {
  int index = 0;  // into RefineScene::views
  std::map<int, std::vector<FeatureMatch>> by_view;
};

class Search {
 public:
  Search(const RefineInput& input, std::size_t first_unposed, const LocateOptions& options,
         const RefineStage& whole)
      : options_(options),
        whole_(whole),
        first_unposed_(first_unposed),
        scene_(ReadScene(input, {.max_side_px = options.max_side_px, .corners = kLocateCorners},
                         whole.Part(0, 0.3))) {
    for (std::size_t v = first_unposed; v < scene_.views.size(); ++v) {
      RefineView& view = scene_.views[v];
      if (view.registered) sought_.push_back({static_cast<int>(v), {}});
      view.registered = false;
    }
    points_.assign(scene_.views.size(), 0);
  }

  std::vector<LocatedPhotograph> Run() {
    double done = 0.3;
    for (bool found = true; found && !sought_.empty();) {
      const RefineStage stage = whole_.Part(done, 0.5 * (1 + done));
      done = 0.5 * (1 + done);
      TriangulateAgain(stage.Part(0, 0.5));
      Adjust();
      Match(stage.Part(0.5, 1));
      found = FindPoses();
    }
    std::vector<LocatedPhotograph> located;
    for (std::size_t v = first_unposed_; v < scene_.views.size(); ++v) {
      const RefineView& view = scene_.views[v];
      LocatedPhotograph& photograph = located.emplace_back();
      photograph.points = points_[v];
      if (view.registered)
        photograph.cam_from_world = view.cam_from_world;
      else
        photograph.why = view.why.empty() ? "shows too little of what the views show" : view.why;
    }
    return located;
  }

 private:
  // Triangulates the points of all views that have poses by now. Pairs that were matched before are not
  // matched again.
  void TriangulateAgain(const RefineStage& stage) {
    const std::vector<std::pair<int, int>> pairs = ChoosePairs(scene_);
    if (!error_px_) error_px_ = MeasurePoseErrorPx(scene_, pairs).value_or(kMostStartErrorPx);
    std::vector<std::pair<int, int>> fresh;
    for (const auto& pair : pairs)
      if (matched_pairs_.insert(pair).second) fresh.push_back(pair);
    for (PairMatches& pair : MatchPairs(scene_, fresh, *error_px_, stage))
      matched_.push_back(std::move(pair));
    BuildTracks(matched_,
                {.gate_px = std::max(kLeastGatePx, kGateErrors * *error_px_),
                 .min_views = scene_.MinViews(),
                 .per_view = kLocatePointsPerView},
                scene_);
    track_of_.assign(scene_.views.size(), {});
    for (std::size_t v = 0; v < scene_.views.size(); ++v)
      track_of_[v].assign(scene_.views[v].features.all().size(), -1);
    for (std::size_t t = 0; t < scene_.tracks.size(); ++t)
      for (const TrackObservation& seen : scene_.tracks[t].observations)
        if (seen.feature >= 0) track_of_[At(seen.view)][At(seen.feature)] = static_cast<int>(t);
  }

  void Match(const RefineStage& stage) {
    struct {
      Mutex mutex;
      std::size_t done ULF_GUARDED_BY(mutex) = 0;
    } matched;
    ParallelFor(sought_.size(), [&](std::size_t s) {
      UnposedPhotograph& photograph = sought_[s];
      const RefineView& own = scene_.view(photograph.index);
      const std::vector<int> all = AllOf(own.features);
      for (int v = 0; v < static_cast<int>(scene_.views.size()); ++v) {
        const RefineView& other = scene_.view(v);
        if (!other.registered || photograph.by_view.contains(v)) continue;
        photograph.by_view[v] =
            MatchAll(own.features, all, other.features, AllOf(other.features), kUnguidedMatches);
      }
      const MutexLock lock(matched.mutex);
      stage.Show(static_cast<double>(++matched.done) / static_cast<double>(sought_.size()),
                 fmt::format("looking for {}", Counted(sought_.size(), "photograph")));
    });
  }

  // Without that, what one photograph is off by adds to the next one's error. It has to reach its minimum: a
  // chain of photographs that hangs on one side only would drift so far that no refinement finds back.
  void Adjust() {
    if (located_ == 0) return;
    BundleProblem problem = ToBundle(scene_);
    for (std::size_t v = 0; v < first_unposed_; ++v) problem.fixed[v] = scene_.views[v].registered;
    std::vector<CameraModel> lenses = scene_.lenses;
    const BundleSummary summary = AdjustBundle(lenses, problem,
                                               {.robust_iterations = kUnguidedIterations,
                                                .iterations = kUnguidedIterations,
                                                .cauchy_scales = kSettledCauchyScales,
                                                .gate_scales = kSettledGateScales});
    if (!summary.usable) return;
    for (std::size_t v = first_unposed_; v < scene_.views.size(); ++v)
      scene_.views[v].cam_from_world = problem.cam_from_world[v];
    for (std::size_t t = 0; t < scene_.tracks.size(); ++t) scene_.tracks[t].position = problem.points[t];
  }

  // Returns whether any pose was found.
  bool FindPoses() {
    std::map<int, AbsolutePoseResult> poses;
    for (const UnposedPhotograph& photograph : sought_)
      if (auto pose = PoseOf(photograph)) poses[photograph.index] = std::move(*pose);
    for (const auto& [index, pose] : poses) {
      RefineView& view = scene_.views[At(index)];
      view.cam_from_world = view.start = pose.cam_from_world;
      view.registered = true;
      points_[At(index)] = static_cast<int>(pose.inliers.size());
    }
    std::erase_if(sought_,
                  [&](const UnposedPhotograph& photograph) { return poses.contains(photograph.index); });
    located_ += poses.size();
    spdlog::debug("{} found, {} left", poses.size(), sought_.size());
    return !poses.empty();
  }

  // Estimates a photograph's pose from the points of the views that look most like it.
  std::optional<AbsolutePoseResult> PoseOf(const UnposedPhotograph& photograph) const {
    std::vector<std::pair<std::size_t, int>> by_matches;
    for (const auto& [view, matches] : photograph.by_view)
      if (matches.size() >= At(kLocateMinMatches)) by_matches.emplace_back(matches.size(), view);
    std::ranges::sort(by_matches, [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    });
    if (by_matches.size() > At(kLocateBestViews)) by_matches.resize(At(kLocateBestViews));
    const RefineView& own = scene_.view(photograph.index);
    std::set<std::pair<int, int>> paired;  // a feature of the photograph, and a track
    std::vector<PointObservation> observations;
    for (const auto& [count, view] : by_matches)
      for (const FeatureMatch& match : photograph.by_view.at(view)) {
        const int track = track_of_[At(view)][At(match.second)];
        if (track < 0 || !paired.emplace(match.first, track).second) continue;
        const Feature& feature = own.features[match.first];
        observations.push_back(
            {scene_.tracks[At(track)].position, feature.img, DetectedSigmaPx(feature.level)});
      }
    return AbsolutePose(
        scene_.LensOf(own), observations,
        {.min_inliers = kLocateMinPoints, .seed = options_.seed + static_cast<unsigned>(photograph.index)});
  }

  const LocateOptions& options_;
  const RefineStage whole_;
  const std::size_t first_unposed_;
  RefineScene scene_;
  std::vector<UnposedPhotograph> sought_;
  std::size_t located_ = 0;
  std::vector<int> points_;         // that agree on a view's pose, by index
  std::optional<double> error_px_;  // of the views' poses
  std::set<std::pair<int, int>> matched_pairs_;
  std::vector<PairMatches> matched_;
  std::vector<std::vector<int>> track_of_;  // by view and feature; -1: none
};

}  // namespace

std::vector<LocatedPhotograph> LocatePhotographs(
    const RefineInput& input, std::size_t first_unposed, const LocateOptions& options,
    const std::function<void(double share, const std::string& stage)>& progress) {
  if (first_unposed < 2)
    throw Error("photographs are found from views that have poses; there are fewer than two");
  Search search(input, first_unposed, options, {progress, 0, 1});
  return search.Run();
}

}  // namespace ulf::tracking
