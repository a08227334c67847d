#include "render/splats/make_splats.h"

#include <algorithm>
#include <optional>
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

void RemoveUnseen(const std::vector<float>& weights, PlacedGaussians& placed) {
  const std::size_t first_around = placed.gaussians.size() - placed.around;
  Gaussians seen;
  placed.around = 0;
  for (std::size_t i = 0; i < placed.gaussians.size(); ++i) {
    if (weights[i] < kLeastWeight_px) continue;
    seen.push_back(placed.gaussians[i]);
    placed.around += i >= first_around;
  }
  placed.gaussians = std::move(seen);
}

}  // namespace

Splats MakeSplats(const RenderScene& scene, const SplatOptions& options) {
  const auto show = [&](double from, double to, const char* what) {
    return [&options, from, to, what](double share) {
      if (options.progress) options.progress(from + (to - from) * share, what);
    };
  };
  std::vector<SplatView> views;
  std::optional<PlacedGaussians> found;
  // Beside edges a cell is a pixel: few Gaussians suffice for small pictures only.
  constexpr double kSmaller = 0.7;
  for (double size_px = options.size_px; !found; size_px *= kSmaller) {
    if (size_px < 1) throw Error("{} Gaussians are too few to show the scene; allow more", options.most);
    views =
        MakeSplatViews(scene, options.views, static_cast<int>(size_px), show(0, kViewsShare, "photographs"));
    found = PlaceGaussians(views, {.most = options.most,
                                   .has_background = !scene.is_cut_out,
                                   .progress = show(kViewsShare, kPlacesShare, "places")});
  }
  PlacedGaussians& placed = *found;
  const ColorFitSummary fit =
      FitColors(ViewsToFit(views), placed.gaussians, {.progress = show(kPlacesShare, 1, "colours")});
  RemoveUnseen(fit.weights, placed);
  return {std::move(placed.gaussians), placed.around, static_cast<int>(views.size()), fit.psnr_db.back()};
}

}  // namespace ulf::render
