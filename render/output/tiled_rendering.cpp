#include "render/output/tiled_rendering.h"

#include <algorithm>
#include <utility>

namespace ulf::render {
namespace {

void Place(const cv::Mat& tile, const cv::Rect& at, const cv::Size& size, cv::Mat& whole) {
  if (tile.empty()) return;
  if (whole.empty()) whole = cv::Mat::zeros(size, tile.type());
  tile.copyTo(whole(at));
}

// Always returns the triangles for the camera of the whole picture.
class WholePictureProxy : public Proxy {
 public:
  WholePictureProxy(std::shared_ptr<const Proxy> proxy, std::shared_ptr<const TriangleMesh> triangles)
      : proxy_(std::move(proxy)), triangles_(std::move(triangles)) {}
  std::string Name() const override { return proxy_->Name(); }
  std::uint64_t Fingerprint() const override { return proxy_->Fingerprint(); }
  PlaneInCamera Background(const Rigid3& cam_from_world) const override {
    return proxy_->Background(cam_from_world);
  }
  std::shared_ptr<const TriangleMesh> Triangles(const CameraModel&, const Rigid3&) const override {
    return triangles_;
  }
  std::shared_ptr<const TriangleMesh> Occluder() const override { return proxy_->Occluder(); }

 private:
  std::shared_ptr<const Proxy> proxy_;
  std::shared_ptr<const TriangleMesh> triangles_;
};

// Some proxies make other triangles for each camera, and so for each tile. While this object lives, the
// renderer uses the triangles of the whole picture.
class WholePictureTriangles {
 public:
  WholePictureTriangles(Renderer& renderer, const CameraModel& camera, const Rigid3& cam_from_world)
      : renderer_(renderer), proxy_(renderer.scene().proxy) {
    auto triangles = proxy_->Triangles(camera, cam_from_world);
    differ_ = triangles && triangles != proxy_->Occluder();
    if (differ_) renderer_.SetProxy(std::make_shared<WholePictureProxy>(proxy_, std::move(triangles)));
  }
  ~WholePictureTriangles() {
    if (differ_) renderer_.SetProxy(proxy_);
  }
  WholePictureTriangles(const WholePictureTriangles&) = delete;
  WholePictureTriangles& operator=(const WholePictureTriangles&) = delete;

 private:
  Renderer& renderer_;
  std::shared_ptr<const Proxy> proxy_;
  bool differ_ = false;
};

}  // namespace

Rendering RenderInTiles(Renderer& renderer, const CameraModel& camera, const Rigid3& cam_from_world,
                        int tile_px) {
  if (camera.width <= tile_px && camera.height <= tile_px) return renderer.Render(camera, cam_from_world);
  const WholePictureTriangles triangles(renderer, camera, cam_from_world);
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
      Place(tile.alpha, at, size, whole.alpha);
      Place(tile.depth, at, size, whole.depth);
      for (const ViewWeights& view : tile.weights) {
        auto found = std::ranges::find_if(whole.weights,
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

}  // namespace ulf::render
