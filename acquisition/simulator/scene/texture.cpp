#include "acquisition/simulator/scene/texture.h"

#include <bit>
#include <cstring>

namespace ulf::acquisition {
namespace {

using U4 = std::uint16_t __attribute__((vector_size(8)));

// log2, within 0.09: the choice of a mip level needs no more. `x` is at least 1.
float RoughLog2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  return exponent + static_cast<float>(bits & 0x7FFFFFu) * (1.0f / 8388608.0f);
}

}  // namespace

MipTexture::MipTexture(int width, int height, bool wrap_u, bool wrap_v, const std::vector<F4>& bgr)
    : wrap_u_(wrap_u), wrap_v_(wrap_v) {
  std::vector<F4> current = bgr;
  int w = width, h = height;
  for (int level = 0; level < kMaxLevels; ++level) {
    levels_.push_back({w, h, texels_.size()});
    for (const F4& value : current) {
      Texel texel{};
      for (int c = 0; c < 3; ++c)
        texel.bgrx[c] =
            static_cast<std::uint16_t>(std::clamp(value[c] * (65535.0f / kFullScale) + 0.5f, 0.0f, 65535.0f));
      texels_.push_back(texel);
    }
    if (w < 4 || h < 4) break;
    const int half_w = w / 2, half_h = h / 2;
    std::vector<F4> next(static_cast<std::size_t>(half_w) * half_h);
    for (int y = 0; y < half_h; ++y)
      for (int x = 0; x < half_w; ++x) {
        const auto at = [&](int dx, int dy) {
          return current[static_cast<std::size_t>(2 * y + dy) * w + static_cast<std::size_t>(2 * x + dx)];
        };
        next[static_cast<std::size_t>(y) * half_w + x] = 0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
      }
    current = std::move(next);
    w = half_w;
    h = half_h;
  }
}

F4 MipTexture::Bilinear(const Level& level, float u, float v) const {
  const float x = u * static_cast<float>(level.width) - 0.5f, y = v * static_cast<float>(level.height) - 0.5f;
  const float floor_x = std::floor(x), floor_y = std::floor(y);
  const float ax = x - floor_x, ay = y - floor_y;
  int x0 = static_cast<int>(floor_x), y0 = static_cast<int>(floor_y);
  int x1 = x0 + 1, y1 = y0 + 1;
  const int last_x = level.width - 1, last_y = level.height - 1;
  if (wrap_u_) {
    x0 = x0 < 0 ? last_x : std::min(x0, last_x);
    x1 = x1 > last_x ? 0 : std::max(x1, 0);
  } else {
    x0 = std::clamp(x0, 0, last_x);
    x1 = std::clamp(x1, 0, last_x);
  }
  if (wrap_v_) {
    y0 = y0 < 0 ? last_y : std::min(y0, last_y);
    y1 = y1 > last_y ? 0 : std::max(y1, 0);
  } else {
    y0 = std::clamp(y0, 0, last_y);
    y1 = std::clamp(y1, 0, last_y);
  }
  const Texel* row0 = texels_.data() + level.first + static_cast<std::size_t>(y0) * level.width;
  const Texel* row1 = texels_.data() + level.first + static_cast<std::size_t>(y1) * level.width;
  const auto load = [](const Texel& texel) {
    U4 raw;
    std::memcpy(&raw, &texel, sizeof(raw));
    return __builtin_convertvector(raw, F4);
  };
  const F4 top = load(row0[x0]) + ax * (load(row0[x1]) - load(row0[x0]));
  const F4 bottom = load(row1[x0]) + ax * (load(row1[x1]) - load(row1[x0]));
  return top + ay * (bottom - top);
}

F4 MipTexture::Sample(float u, float v, float footprint) const {
  constexpr float kScale = kFullScale / 65535.0f;
  const int last = static_cast<int>(levels_.size()) - 1;
  const float lod = RoughLog2(std::max(1.0f, footprint));
  const int fine = std::min(static_cast<int>(lod), last);
  // Levels are blended over the middle half of the way between them: half the look-ups, and no seam.
  const float part = std::clamp(2 * (lod - static_cast<float>(fine)) - 0.5f, 0.0f, 1.0f);
  if (fine < last && part >= 1) return kScale * Bilinear(levels_[static_cast<std::size_t>(fine) + 1], u, v);
  const F4 a = Bilinear(levels_[static_cast<std::size_t>(fine)], u, v);
  if (fine == last || part <= 0) return kScale * a;
  const F4 b = Bilinear(levels_[static_cast<std::size_t>(fine) + 1], u, v);
  return kScale * (a + part * (b - a));
}

}  // namespace ulf::acquisition
