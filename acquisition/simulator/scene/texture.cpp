#include "acquisition/simulator/scene/texture.h"

#include <bit>
#include <cstring>
#include <utility>

namespace ulf::acquisition {
namespace {

using U4 = std::uint16_t __attribute__((vector_size(8)));

// log2 within 0.09, which is enough to choose a mip level. `x` is at least 1.
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
  const auto neighbours = [](int first, int last, bool wrap) -> std::pair<int, int> {
    const int second = first + 1;
    if (!wrap) return {std::clamp(first, 0, last), std::clamp(second, 0, last)};
    return {first < 0 ? last : std::min(first, last), second > last ? 0 : std::max(second, 0)};
  };
  const auto [x0, x1] = neighbours(static_cast<int>(floor_x), level.width - 1, wrap_u_);
  const auto [y0, y1] = neighbours(static_cast<int>(floor_y), level.height - 1, wrap_v_);
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
  // Blends two levels only over the middle half of the way between them, which saves half the look-ups.
  const float part = std::clamp(2 * (lod - static_cast<float>(fine)) - 0.5f, 0.0f, 1.0f);
  if (fine < last && part >= 1) return kScale * Bilinear(levels_[static_cast<std::size_t>(fine) + 1], u, v);
  const F4 a = Bilinear(levels_[static_cast<std::size_t>(fine)], u, v);
  if (fine == last || part <= 0) return kScale * a;
  const F4 b = Bilinear(levels_[static_cast<std::size_t>(fine) + 1], u, v);
  return kScale * (a + part * (b - a));
}

}  // namespace ulf::acquisition
