// The views' depth maps (ViewDepthMap) in graphics memory: a layer of a texture array for each view that was
// requested so far, GL_R16. The context must be current for all functions.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "render/scene/scene.h"

namespace ulf::render {

class GlDepthMaps {
 public:
  // Forgets all maps; comes first. `views` must stay unchanged until the next Reset(), for another proxy.
  void Reset(const std::vector<SceneView>& views);
  // Makes or reads the maps that are missing of these views (indices), on all processors. Throws Error if
  // OpenGL has no room for so many.
  void Provide(std::span<const int> of_views);
  // Returns -1 for a view whose map was not provided, or that has none.
  int LayerOf(int view) const { return layer_[static_cast<std::size_t>(view)]; }
  void Bind(unsigned unit) const;
  void Release();

 private:
  void Grow(const cv::Size& size, int layers);
  void Upload(int view);

  const std::vector<SceneView>* views_ = nullptr;
  std::vector<int> layer_;
  std::vector<int> held_;  // views, by layer
  cv::Size size_;          // of all layers: the largest map's size
  int layers_ = 0;
  unsigned texture_ = 0;
};

}  // namespace ulf::render
