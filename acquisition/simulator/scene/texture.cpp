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

std::vector<MipTexture::Level> MipTexture::LevelsOf(int width, int height) {
  std::vector<Level> levels;
  std::size_t first = 0;
  for (int level = 0; level < kMaxLevels; ++level) {
    levels.push_back({width, height, first});
    if (width < 4 || height < 4) break;
    first += static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    width /= 2;
    height /= 2;
  }
  return levels;
}

std::size_t MipTexture::CountOf(const std::vector<Level>& levels) {
  const Level& last = levels.back();
  return last.first + static_cast<std::size_t>(last.width) * static_cast<std::size_t>(last.height);
}

std::size_t MipTexture::BytesOf(int width, int height) {
  return CountOf(LevelsOf(width, height)) * sizeof(Texel);
}

std::span<const std::byte> MipTexture::Texels() const {
  return std::as_bytes(std::span(texels_.get(), levels_.empty() ? 0 : CountOf(levels_)));
}

MipTexture::MipTexture(int width, int height, bool wrap_u, bool wrap_v,
                       const std::shared_ptr<const void>& texels)
    : levels_(LevelsOf(width, height)),
      texels_(texels, static_cast<const Texel*>(texels.get())),
      wrap_u_(wrap_u),
      wrap_v_(wrap_v) {}

MipTexture::MipTexture(int width, int height, bool wrap_u, bool wrap_v, const std::vector<F4>& bgr)
    : levels_(LevelsOf(width, height)), wrap_u_(wrap_u), wrap_v_(wrap_v) {
  const auto texels = std::make_shared<std::vector<Texel>>();
  texels->reserve(CountOf(levels_));
  std::vector<F4> current = bgr;
  int w = width;
  for (const Level& level : levels_) {
    if (level.first > 0) {
      std::vector<F4> halved(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height));
      for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
          const auto at = [&](int dx, int dy) {
            return current[static_cast<std::size_t>(2 * y + dy) * w + static_cast<std::size_t>(2 * x + dx)];
          };
          halved[static_cast<std::size_t>(y) * level.width + x] =
              0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
        }
      current = std::move(halved);
      w = level.width;
    }
    for (const F4& value : current) {
      Texel texel{};
      for (int c = 0; c < 3; ++c)
        texel.bgrx[c] =
            static_cast<std::uint16_t>(std::clamp(value[c] * (65535.0f / kFullScale) + 0.5f, 0.0f, 65535.0f));
      texels->push_back(texel);
    }
  }
  texels_ = std::shared_ptr<const Texel>(texels, texels->data());
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
  const Texel* row0 = texels_.get() + level.first + static_cast<std::size_t>(y0) * level.width;
  const Texel* row1 = texels_.get() + level.first + static_cast<std::size_t>(y1) * level.width;
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
