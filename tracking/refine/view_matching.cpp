#include "tracking/refine/view_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/mutex.h"

namespace ulf::tracking {

RefineScene SceneOf(const RefineInput& input, int max_side_px) {
  RefineScene scene;
  for (const CameraModel& lens : input.lenses) {
    const double share = std::min(1.0, static_cast<double>(max_side_px) / std::max(lens.width, lens.height));
    scene.lenses.push_back(lens.ScaledTo(static_cast<int>(std::lround(share * lens.width)),
                                         static_cast<int>(std::lround(share * lens.height))));
  }
  for (const RefineInput::View& given : input.views) {
    RefineView& view = scene.views.emplace_back();
    view.name = given.name;
    view.lens = given.lens;
    view.start = view.cam_from_world = given.cam_from_world;
  }
  return scene;
}

std::vector<PairMatches> MatchPairs(const RefineScene& scene, const std::vector<std::pair<int, int>>& pairs,
                                    double error_px, const RefineStage& stage) {
  const double band_px = std::max(2.0, 4 * error_px);
  std::vector<PairMatches> matched(pairs.size());
  struct {
    Mutex mutex;
    int done ULF_GUARDED_BY(mutex) = 0;
  } shown;
  ForAll(static_cast<int>(pairs.size()), [&](int p) {
    const auto [first, second] = pairs[static_cast<std::size_t>(p)];
    PairMatches& pair = matched[static_cast<std::size_t>(p)];
    if (error_px < kGuidingErrorPx) {
      const RefineView &a = scene.view(first), &b = scene.view(second);
      pair = {first, second,
              MatchAlongEpipolarLines(a.features, b.features, b.cam_from_world * a.cam_from_world.Inverse(),
                                      scene.LensOf(a).MeanFocalPx(), band_px,
                                      {.max_distance = 60, .max_ratio = 0.85}),
              0};
      pair.alike = static_cast<int>(pair.matches.size());
    } else {
      pair = MatchAroundPose(scene, first, second, error_px, kMinPairMatches);
    }
    if (static_cast<int>(pair.matches.size()) < kMinPairMatches) pair.matches.clear();
    const MutexLock lock(shown.mutex);
    stage.Show(static_cast<double>(++shown.done) / static_cast<double>(pairs.size()),
               fmt::format("comparing views, pair {} of {}", shown.done, pairs.size()));
  });
  return matched;
}

}  // namespace ulf::tracking
