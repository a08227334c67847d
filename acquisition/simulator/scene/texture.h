// Stores surface radiance as a texture: linear B, G, R in 16 bits, with a mip pyramid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "acquisition/simulator/scene/lanes.h"

namespace ulf::acquisition {

class MipTexture {
 public:
  // Full scale of the stored integers in units of radiance (RayCaster: 1 is a white card in the key light).
  static constexpr float kFullScale = 4.0f;

  MipTexture() = default;
  // `bgr` holds width * height values, row by row. `wrap_u`, `wrap_v`: the texture continues at the opposite
  // edge; for that to be seamless in every level, the size must be a multiple of 2^(kMaxLevels-1).
  MipTexture(int width, int height, bool wrap_u, bool wrap_v, const std::vector<F4>& bgr);
  // Shares, without a copy, the texels of an equal texture's Texels(): BytesOf() bytes, aligned to 8.
  MipTexture(int width, int height, bool wrap_u, bool wrap_v, const std::shared_ptr<const void>& texels);
  static std::size_t BytesOf(int width, int height);
  std::span<const std::byte> Texels() const;

  int width() const { return levels_.empty() ? 0 : levels_[0].width; }
  int height() const { return levels_.empty() ? 0 : levels_[0].height; }
  bool wrap_u() const { return wrap_u_; }
  bool wrap_v() const { return wrap_v_; }

  // Returns the filtered radiance; not of an empty texture. u, v: 0 to 1 from the edges of the first
  // column and row, not periodic. `footprint`: side of the area that a pixel of the image sees, in texels
  // of the finest level.
  F4 Sample(float u, float v, float footprint) const;

 private:
  static constexpr int kMaxLevels = 6;
  struct Level {
    int width = 0, height = 0;
    std::size_t first = 0;
  };
  struct alignas(8) Texel {
    std::uint16_t bgrx[4];
  };
  static std::vector<Level> LevelsOf(int width, int height);
  static std::size_t CountOf(const std::vector<Level>& levels);
  F4 Bilinear(const Level& level, float u, float v) const;

  std::vector<Level> levels_;
  std::shared_ptr<const Texel> texels_;  // the first of all levels'
  bool wrap_u_ = false, wrap_v_ = false;
};

}  // namespace ulf::acquisition
