#include "render/splats/make_splats.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "render/splats/color_fit.h"
#include "render/splats/placing.h"
#include "render/splats/splat_views.h"

namespace ulf::render {
namespace {

// Shares of the displayed progress: photographs, places; the rest is for colours.
constexpr double kViewsShare = 0.15, kPlacesShare = 0.4;

// Gaussians with less weight in all pictures together are removed, px.
constexpr float kLeastWeight_px = 0.05f;

std::vector<ColorFitView> ViewsToFit(const std::vector<SplatView>& views) {
  std::vector<ColorFitView> to_fit;
  for (const SplatView& view : views) to_fit.push_back({view.camera, view.cam_from_world, view.photograph});
  return to_fit;
}

// The backdrop is there for pictures that nobody took yet, and stays.
void RemoveUnseen(const std::vector<float>& weights, PlacedGaussians& placed) {
  const std::size_t first_behind = placed.gaussians.size() - placed.behind;
  const std::size_t first_around = first_behind - placed.around;
  Gaussians seen;
  placed.around = 0;
  for (std::size_t i = 0; i < placed.gaussians.size(); ++i) {
    if (weights[i] < kLeastWeight_px && i < first_behind) continue;
    seen.push_back(placed.gaussians[i]);
    placed.around += i >= first_around && i < first_behind;
  }
  placed.gaussians = std::move(seen);
}

// Cells are those of smaller pictures if there would be too many.
PlacedGaussians PlaceWithin(const std::vector<SplatView>& views, const PlacingOptions& options) {
  constexpr double kRoom = 0.95;     // of the count, to which the next try comes
  constexpr double kSmaller = 0.95;  // at least, from try to try
  std::vector<SplatView> here = views;
  double size_px = LongestSide(views);
  for (;;) {
    PlacedGaussians placed = PlaceGaussians(here, options);
    if (!(placed.too_many > 0)) return placed;
    size_px *= std::min(kSmaller, std::sqrt(kRoom / placed.too_many));
    if (size_px < 1) throw Error("{} Gaussians are too few to show the scene; allow more", options.most);
    here = Reduced(views, static_cast<int>(size_px));
  }
}

}  // namespace

Splats MakeSplats(const RenderScene& scene, const SplatOptions& options) {
  const auto show = [&](double from, double to, const char* what) {
    return [&options, from, to, what](double share) {
      if (options.progress) options.progress(from + (to - from) * share, what);
    };
  };
  const std::vector<SplatView> views =
      MakeSplatViews(scene, options.views, options.most_px, show(0, kViewsShare, "photographs"));
  PlacedGaussians placed = PlaceWithin(views, {.most = options.most,
                                               .has_background = !scene.is_cut_out,
                                               .progress = show(kViewsShare, kPlacesShare, "places")});
  const ColorFitSummary fit =
      FitColors(ViewsToFit(views), placed.gaussians, {.progress = show(kPlacesShare, 1, "colours")});
  RemoveUnseen(fit.weights, placed);
  return {std::move(placed.gaussians), placed.around + placed.behind, static_cast<int>(views.size()),
          fit.psnr_db.back()};
}

}  // namespace ulf::render
