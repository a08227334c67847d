#include "render/tiled_rendering.h"

#include <algorithm>

namespace ulf {
namespace {

void Place(const cv::Mat& tile, const cv::Rect& at, const cv::Size& size, cv::Mat& whole) {
  if (tile.empty()) return;
  if (whole.empty()) whole = cv::Mat::zeros(size, tile.type());
  tile.copyTo(whole(at));
}

}  // namespace

Rendering RenderInTiles(Renderer& renderer, const CameraModel& camera, const Rigid3& cam_from_world,
                        int tile_px) {
  if (camera.width <= tile_px && camera.height <= tile_px) return renderer.Render(camera, cam_from_world);
  Rendering whole;
  const cv::Size size(camera.width, camera.height);
  for (int top = 0; top < camera.height; top += tile_px)
    for (int left = 0; left < camera.width; left += tile_px) {
      const cv::Rect at(left, top, std::min(tile_px, camera.width - left),
                        std::min(tile_px, camera.height - top));
      CameraModel of_tile = camera;
      of_tile.width = at.width;
      of_tile.height = at.height;
      of_tile.cx -= left;
      of_tile.cy -= top;
      const Rendering tile = renderer.Render(of_tile, cam_from_world);
      Place(tile.linear, at, size, whole.linear);
      Place(tile.confidence, at, size, whole.confidence);
      Place(tile.drawn, at, size, whole.drawn);
      Place(tile.depth, at, size, whole.depth);
      for (const ViewWeights& view : tile.weights) {
        auto found = std::find_if(whole.weights.begin(), whole.weights.end(),
                                  [&](const ViewWeights& w) { return w.view_id == view.view_id; });
        if (found == whole.weights.end()) found = whole.weights.insert(found, {view.view_id, {}});
        Place(view.weight, at, size, found->weight);
      }
      whole.filled_px += tile.filled_px;
      whole.empty_px += tile.empty_px;
      whole.ms += tile.ms;
    }
  return whole;
}

}  // namespace ulf
