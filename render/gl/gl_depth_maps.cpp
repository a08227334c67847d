#include "render/gl/gl_depth_maps.h"

#include <epoxy/gl.h>

#include <algorithm>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "render/gl/gl_objects.h"

namespace ulf::render {

// Software OpenGL makes no larger texture array (gl_photographs.cpp).
constexpr double kMostBytes = 2e9;

void GlDepthMaps::Reset(const std::vector<SceneView>& views) {
  views_ = &views;
  layer_.assign(views.size(), -1);
  held_.clear();
  if (std::ranges::none_of(views, [](const SceneView& view) { return view.depth_map != nullptr; })) Release();
}

void GlDepthMaps::Provide(std::span<const int> of_views) {
  std::vector<int> missing;
  std::ranges::copy_if(of_views, std::back_inserter(missing),
                       [&](int view) { return LayerOf(view) < 0 && (*views_)[At(view)].depth_map; });
  if (missing.empty()) return;
  ParallelFor(missing.size(), [&](std::size_t i) { (*views_)[At(missing[i])].depth_map->Get(); });
  cv::Size size = size_;
  for (const int view : missing) {
    const cv::Mat& map = (*views_)[At(view)].depth_map->Get().inverse_depth;
    size = {std::max(size.width, map.cols), std::max(size.height, map.rows)};
  }
  const int wanted = static_cast<int>(held_.size() + missing.size());
  if (size != size_ || wanted > layers_) Grow(size, wanted);
  for (const int view : missing) {
    layer_[At(view)] = static_cast<int>(held_.size());
    held_.push_back(view);
    Upload(view);
  }
  CheckGl("copying depth maps");
}

void GlDepthMaps::Grow(const cv::Size& size, int layers) {
  const int most_layers = MostLayers();
  if (layers > most_layers)
    throw Error(
        "OpenGL: this driver has room for the depth maps of {} views, not for more; use {} auto without "
        "soft, or {} reference",
        most_layers, Parameter("field"), Parameter("renderer"));
  const auto bytes = [&](int count) { return 2.0 * size.area() * count; };
  if (bytes(layers) > kMostBytes)
    throw Error(
        "the depth maps of {} views of {}x{} take more than {:.0f} GB of graphics memory; make smaller ones "
        "with ulf proxy --size, or use {} reference, or another {} than soft",
        layers, size.width, size.height, kMostBytes / 1e9, Parameter("renderer"), Parameter("field"));
  const int wanted = std::min({std::max(layers, 2 * layers_), static_cast<int>(layer_.size()), most_layers});
  Release();
  const int made = bytes(wanted) > kMostBytes ? layers : wanted;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture_);
  glTextureStorage3D(texture_, 1, GL_R16, size.width, size.height, made);
  CheckMade("making room for depth maps", [&] { Reset(*views_), Release(); });
  size_ = size;
  layers_ = made;
  SetSampling(texture_, GL_NEAREST);
  for (const int view : held_) Upload(view);
}

void GlDepthMaps::Upload(int view) {
  const cv::Mat map = (*views_)[At(view)].depth_map->Get().inverse_depth;
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  glTextureSubImage3D(texture_, 0, 0, 0, LayerOf(view), map.cols, map.rows, 1, GL_RED, GL_UNSIGNED_SHORT,
                      map.data);
}

void GlDepthMaps::Bind(unsigned unit) const { glBindTextureUnit(unit, texture_); }

void GlDepthMaps::Release() {
  if (texture_) glDeleteTextures(1, &texture_);
  texture_ = 0;
  layers_ = 0;
  size_ = {};
}

}  // namespace ulf::render
