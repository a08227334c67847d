#include "commands/rendering/refined_split.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "tracking/refine/refine.h"
#include "tracking/refine/refine_input.h"

namespace ulf::commands {
namespace {

struct Refined {
  LightField views;  // unrefined
  tracking::RefineResult result;
};

Refined RefineViews(const LightField& all, const std::vector<int>& views, bool lens, const char* stage,
                    Progress& progress) {
  Refined refined;
  refined.views = all;
  refined.views.points.clear();
  refined.views.views.clear();
  for (const int view : views) refined.views.views.push_back(all.views[At(view)]);
  tracking::RefineOptions options;
  options.intrinsics = lens;
  options.all_points = true;
  options.progress = [&](double share, const std::string& what) {
    progress.Show(share, fmt::format("{}: {}", stage, what));
  };
  refined.result = tracking::Refine(tracking::RefineInputOf(refined.views), options);
  return refined;
}

// A refinement does not determine the world's frame, and bends the world by less than a pixel. A view is
// placed in another refinement's world by its pose relative to its nearest neighbour: alignment by centres
// alone would rotate it by pixels.
std::optional<Rigid3> PlacedByNeighbour(const Refined& own, std::size_t view, const Refined& other) {
  std::optional<Rigid3> placed;
  double nearest = std::numeric_limits<double>::infinity();
  const Rigid3& pose = own.result.views[view].cam_from_world;
  for (std::size_t i = 0; i < other.views.views.size(); ++i) {
    const auto same = std::ranges::find(own.views.views, other.views.views[i].id, &View::id);
    const auto at = static_cast<std::size_t>(same - own.views.views.begin());
    if (!other.result.views[i].registered || !own.result.views[at].registered) continue;
    const Rigid3& neighbour = own.result.views[at].cam_from_world;
    const double distance = (neighbour.OriginInSource() - pose.OriginInSource()).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    placed = pose * neighbour.Inverse() * other.result.views[i].cam_from_world;
  }
  return placed;
}

}  // namespace

RefinedSplit RefineForProtocol(const LightField& all, const render::ProtocolSplit& split,
                               Progress& progress) {
  std::vector<int> used = split.given;
  used.insert(used.end(), split.test.begin(), split.test.end());
  std::ranges::sort(used);
  const Refined given = RefineViews(all, split.given, true, "given views", progress);
  RefinedSplit refined{all, {}, given.result.median_before_px, given.result.median_after_px};
  refined.light_field.cameras = given.result.lenses;
  for (std::size_t i = 0; i < split.given.size(); ++i)
    refined.light_field.views[At(split.given[i])].cam_from_world = given.result.views[i].cam_from_world;
  // Uses the given views' lens: another one would shift the others.
  const Refined together = RefineViews(refined.light_field, used, false, "places of the others", progress);
  refined.light_field.points = tracking::WithViewIds(given.result.points, given.views);
  for (const int test : split.test) {
    const auto at = static_cast<std::size_t>(std::ranges::find(used, test) - used.begin());
    if (!together.result.views[at].registered) ++refined.not_placed;  // its pose to the neighbour stays
    if (const auto placed = PlacedByNeighbour(together, at, given))
      refined.light_field.views[At(test)].cam_from_world = *placed;
  }
  std::string lens;
  if (all.cameras.size() == 1 && !(given.result.lenses[0] == all.cameras[0]))
    lens = fmt::format("; focal length {:.1f} px for {:.1f}, k1 {:.4f} for {:.4f}", given.result.lenses[0].fx,
                       all.cameras[0].fx, given.result.lenses[0].coefficients[0],
                       all.cameras[0].coefficients[0]);
  refined.summary = fmt::format("refined: points of the given views are off by {:.3f} px, {:.3f} before{}",
                                given.result.median_after_px, given.result.median_before_px, lens);
  for (const tracking::RefinedView& view : given.result.views) refined.not_registered += !view.registered;
  if (refined.not_registered > 0)
    refined.summary += fmt::format("; {} kept {} pose", Counted(refined.not_registered, "given view"),
                                   refined.not_registered == 1 ? "its" : "their");
  if (refined.not_placed > 0)
    refined.summary +=
        fmt::format("; {} too little to say where {} taken from",
                    refined.not_placed == 1 ? "one left-out photograph shows"
                                            : fmt::format("{} left-out photographs show", refined.not_placed),
                    refined.not_placed == 1 ? "it was" : "they were");
  return refined;
}

}  // namespace ulf::commands
