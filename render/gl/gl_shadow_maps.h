// The views' shadow maps in graphics memory: a layer of a texture array for each view that was requested so
// far. The context must be current for all functions.
#pragma once

#include <span>
#include <vector>

#include "render/scene/scene.h"

namespace ulf::render {

// Depth textures hold 0 to 1, while inverse depths depend on the scene's unit. The textures hold them times
// this factor, a power of two, which loses no bit.
inline constexpr float kShadowMapScale = 0x1p-64f;

class GlShadowMaps {
 public:
  // Forgets all maps; comes first. `views` must stay unchanged until the next Reset(), for another proxy.
  void Reset(const std::vector<SceneView>& views);
  // Makes the maps that are missing of these views (indices), on all processors; returns whether there were
  // any. Throws Error if OpenGL has no room for so many.
  bool Provide(std::span<const int> of_views);
  // Returns -1 without a map yet. If the proxy hides nothing, all views have layer 0, which no shader reads.
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
