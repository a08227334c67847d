#include "tracking/refine/pose_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <unordered_map>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/triangulation.h"
#include "tracking/refine/view_matching.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {
namespace {

// Of all pairs, those of the first views on either side: each view keeps `most` of its own.
std::vector<std::pair<int, int>> FewPairs(const RefineScene& scene, int most) {
  std::vector<int> taken(scene.views.size(), 0);
  std::vector<std::pair<int, int>> few;
  for (const auto& pair : ChoosePairs(scene)) {
    int &first = taken[At(pair.first)], &second = taken[At(pair.second)];
    if (first >= most && second >= most) continue;
    ++first;
    ++second;
    few.push_back(pair);
  }
  return few;
}

// Which views agree with others, and how well.
class Agreement {
 public:
  Agreement(const RefineScene& scene, const RefineInput& input, const PoseCheckOptions& options)
      : scene_(scene),
        input_(input),
        options_(options),
        told_(scene.views.size()),
        agrees_(scene.views.size()) {}

  // `errors_px`: of the matches that these views share, pixels of the view `in`.
  void Note(std::initializer_list<int> views, int in, const std::vector<double>& errors_px) {
    if (errors_px.size() < options_.min_matches) return;
    const RefineView& view = scene_.view(in);
    const CameraModel& lens = scene_.LensOf(view);
    const auto near = std::ranges::count_if(
        errors_px, [&](double error) { return error < options_.near_share * lens.width; });
    const bool agree =
        static_cast<double>(near) >= options_.agreeing_share * static_cast<double>(errors_px.size());
    for (const int each : views) {
      told_[At(each)] = true;
      if (agree) agrees_[At(each)] = true;
    }
    if (agree) medians_px_.push_back(Median(errors_px) * input_.lenses[At(view.lens)].width / lens.width);
  }
  bool IsTold(int view) const { return told_[At(view)]; }
  bool Agrees(int view) const { return agrees_[At(view)]; }
  double MedianPx() const { return Median(medians_px_); }

 private:
  const RefineScene& scene_;
  const RefineInput& input_;
  const PoseCheckOptions& options_;
  std::vector<bool> told_, agrees_;
  std::vector<double> medians_px_;
};

// Corners of a view by the corner of another view that matches.
std::unordered_map<int, int> MatchesFrom(const UnguidedPair& pair, int view) {
  std::unordered_map<int, int> matches;
  for (const FeatureMatch& match : pair.matches)
    matches[pair.first == view ? match.first : match.second] =
        pair.first == view ? match.second : match.first;
  return matches;
}

int OtherOf(const UnguidedPair& pair, int view) { return pair.first == view ? pair.second : pair.first; }

// For each corner that `view` and both others show: how far, px of the second, from where the first two put it.
std::vector<double> ErrorsInThird(const RefineScene& scene, int view, const UnguidedPair& first,
                                  const UnguidedPair& second) {
  const RefineView &own = scene.view(view), &one = scene.view(OtherOf(first, view)),
                   &other = scene.view(OtherOf(second, view));
  const std::unordered_map<int, int> in_other = MatchesFrom(second, view);
  std::vector<double> errors;
  for (const auto& [corner, in_one] : MatchesFrom(first, view)) {
    const auto seen = in_other.find(corner);
    if (seen == in_other.end()) continue;
    const auto point = TriangulatePoint(own.cam_from_world, own.features[corner].ray, one.cam_from_world,
                                        one.features[in_one].ray);
    const auto img = point ? scene.LensOf(other).ImgFromCam(other.cam_from_world * *point) : std::nullopt;
    errors.push_back(img ? (*img - other.features[seen->second].img).norm()
                         : std::numeric_limits<double>::infinity());
  }
  return errors;
}

}  // namespace

PoseCheck CheckPoses(const RefineInput& input, const PoseCheckOptions& options) {
  const RefineStage reading{options.progress, 0, 0.6}, matching{options.progress, 0.6, 1};
  const RefineScene scene =
      ReadScene(input, {.max_side_px = options.max_side_px, .corners = options.corners}, reading);
  PoseCheck check;
  for (const RefineView& view : scene.views)
    if (!view.registered) check.unread.push_back(view.why);
  const std::vector<std::pair<int, int>> chosen = FewPairs(scene, options.pairs_per_view);
  std::vector<UnguidedPair> pairs(chosen.size());
  matching.Show(0, "comparing photographs with their poses");
  ParallelFor(pairs.size(),
              [&](std::size_t p) { pairs[p] = MatchUnguided(scene, chosen[p].first, chosen[p].second); });

  Agreement agreement(scene, input, options);
  std::vector<std::vector<const UnguidedPair*>> of_view(scene.views.size());
  for (const UnguidedPair& pair : pairs)
    for (const int view : {pair.first, pair.second}) of_view[At(view)].push_back(&pair);
  for (int view = 0; view < static_cast<int>(scene.views.size()); ++view) {
    auto& own = of_view[At(view)];
    const auto distance_to = [&](const UnguidedPair* pair) {
      return (scene.view(OtherOf(*pair, view)).cam_from_world.OriginInSource() -
              scene.view(view).cam_from_world.OriginInSource())
          .norm();
    };
    // The farther one of two gives the better depth.
    std::ranges::sort(own, std::greater(), distance_to);
    for (std::size_t i = 0; i < own.size(); ++i)
      for (std::size_t j = i + 1; j < own.size(); ++j)
        agreement.Note({view, OtherOf(*own[i], view), OtherOf(*own[j], view)}, OtherOf(*own[j], view),
                       ErrorsInThird(scene, view, *own[i], *own[j]));
  }
  Agreement of_pairs(scene, input, options);
  for (const UnguidedPair& pair : pairs) of_pairs.Note({pair.first, pair.second}, pair.first, pair.errors_px);

  for (int view = 0; view < static_cast<int>(scene.views.size()); ++view) {
    const Agreement& tells = agreement.IsTold(view) ? agreement : of_pairs;
    if (!tells.IsTold(view))
      ++check.untold;
    else if (tells.Agrees(view))
      ++check.agree;
    else
      check.disagree.push_back(view);
  }
  check.error_px = of_pairs.MedianPx();
  return check;
}

std::string InWords(const PoseCheck& check, const std::vector<std::string>& names) {
  if (check.disagree.empty()) return {};
  constexpr std::size_t kNamed = 4;
  std::string which;
  for (std::size_t i = 0; i < std::min(kNamed, check.disagree.size()); ++i)
    which += (i == 0 ? "" : ", ") + names[At(check.disagree[i])];
  const std::size_t told = check.disagree.size() + static_cast<std::size_t>(check.agree);
  const bool most = 2 * check.disagree.size() > told;
  return fmt::format(
      "the poses of {} of {} disagree with what the photographs show ({}{}): {}", check.disagree.size(),
      Counted(told, "view"), which, check.disagree.size() > kNamed ? ", ..." : "",
      most ? "are the photographs in another order than the poses, or cropped, or by another lens?"
           : "are they others than those that were posed?");
}

}  // namespace ulf::tracking
