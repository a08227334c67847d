#include "render/gl/gl_shadow_maps.h"

#include <epoxy/gl.h>

#include <algorithm>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "render/gl/gl_objects.h"

namespace ulf::render {

void GlShadowMaps::Reset(const std::vector<SceneView>& views) {
  views_ = &views;
  const bool hides =
      std::ranges::any_of(views, [](const SceneView& view) { return view.shadow_map != nullptr; });
  layer_.assign(views.size(), hides ? -1 : 0);
  used_ = 0;
}

bool GlShadowMaps::HasAll(std::span<const int> of_views) const {
  return std::ranges::all_of(of_views, [&](int view) { return LayerOf(view) >= 0; });
}

bool GlShadowMaps::Provide(std::span<const int> of_views) {
  std::vector<int> missing;
  std::ranges::copy_if(of_views, std::back_inserter(missing), [&](int view) { return LayerOf(view) < 0; });
  if (missing.empty()) return false;
  const int count = static_cast<int>(missing.size());
  ParallelFor(missing.size(), [&](std::size_t i) { (*views_)[At(missing[i])].shadow_map->Get(); });
  if (used_ + count > layers_) Grow(used_ + count);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  cv::Mat scaled;
  for (const int view : missing) {
    layer_[At(view)] = used_++;
    scaled = kShadowMapScale * (*views_)[At(view)].shadow_map->Get().least_inverse_depth;
    glTextureSubImage3D(texture_, 0, 0, 0, LayerOf(view), kShadowMapPx, kShadowMapPx, 1, GL_DEPTH_COMPONENT,
                        GL_FLOAT, scaled.data);
  }
  CheckGl("copying shadow maps");
  return true;
}

void GlShadowMaps::Grow(int least) {
  const int most_layers = MostLayers();
  const int layers = std::min({std::max(least, 2 * layers_), static_cast<int>(layer_.size()), most_layers});
  if (layers < least)
    throw Error(
        "OpenGL: this driver has room for the shadow maps of {} views, not for more; use {} plane, or "
        "ulf render --renderer reference",
        most_layers, Parameter("proxy"));
  unsigned larger = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &larger);
  glTextureStorage3D(larger, 1, GL_DEPTH_COMPONENT32F, kShadowMapPx, kShadowMapPx, layers);
  CheckMade("making room for shadow maps", [&] { glDeleteTextures(1, &larger); });
  SetSampling(larger, GL_LINEAR);
  glTextureParameteri(larger, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTextureParameteri(larger, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
  if (used_ > 0)
    glCopyImageSubData(texture_, GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, larger, GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0,
                       kShadowMapPx, kShadowMapPx, used_);
  if (texture_) glDeleteTextures(1, &texture_);
  texture_ = larger;
  layers_ = layers;
}

void GlShadowMaps::Bind(unsigned unit) const { glBindTextureUnit(unit, texture_); }

void GlShadowMaps::Release() {
  if (texture_) glDeleteTextures(1, &texture_);
  texture_ = 0;
  used_ = layers_ = 0;
}

}  // namespace ulf::render
