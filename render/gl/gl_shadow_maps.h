// What the proxy hides from the views, on the graphics side: a layer of a texture array for each view that
// was asked for so far. As GlContext's objects, all need their context to be current.
#pragma once

#include <span>
#include <vector>

#include "render/scene/scene.h"

namespace ulf::render {

// Depth textures hold 0 to 1, while inverse depths are as large as the scene's unit makes them: the maps keep
// them times this, a power of two, so that not a bit is lost.
inline constexpr float kShadowMapScale = 0x1p-64f;

class GlShadowMaps {
 public:
  // Forgets all: the scene has another proxy. The views must stay as they are until then.
  void Reset(const std::vector<SceneView>& views);
  // Makes those that are missing (all processors); whether there were any. Error when there are too many.
  bool Provide(std::span<const int> of_views);
  // -1: not there. Where nothing hides anything all are there, in a layer that nobody reads.
  int LayerOf(int view) const { return layer_[static_cast<std::size_t>(view)]; }
  bool HasAll(std::span<const int> of_views) const;
  void Bind(unsigned unit) const;
  void Release();

 private:
  void Grow(int least);

  const std::vector<SceneView>* views_ = nullptr;
  std::vector<int> layer_;
  int used_ = 0, layers_ = 0;
  unsigned texture_ = 0;
};

}  // namespace ulf::render
