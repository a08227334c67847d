#include "render/output/picture_memory.h"

#include <algorithm>

#include "core/base/error.h"
#include "render/output/tiled_rendering.h"

namespace ulf::render {

std::uint64_t MemoryForPicture(int width, int height, const PictureEncoding& encoding) {
  constexpr std::uint64_t kRendered = 12 + 4 + 1, kDepth = 4;  // light, confidence, whether drawn
  constexpr std::uint64_t kTargets = 60;                       // OpenGL's images and their copies in memory
  const auto encoded = [&]() -> std::uint64_t {
    switch (encoding.format) {
      case PictureFormat::kPng:
        return 3 * 3;  // pixels, the file, its copy
      case PictureFormat::kPng16:
        return 3 * 6;
      default:
        return kDepth + 10 + 4 +
               2 * 14;  // half floats; the file, at worst as large, and its copy while it grows
    }
  }();
  const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  const auto tile = static_cast<std::uint64_t>(std::min(width, kTilePx)) *
                    static_cast<std::uint64_t>(std::min(height, kTilePx));
  return pixels * (kRendered + encoded) + tile * kTargets;
}

void RequireMemory(int width, int height, const PictureEncoding& encoding, std::uint64_t available) {
  const std::uint64_t needed = MemoryForPicture(width, height, encoding);
  if (needed > available)
    throw Error(
        "a picture of {}x{} takes about {:.1f} GB of memory and {:.1f} GB are free; give a smaller --width "
        "or --height",
        width, height, 1e-9 * static_cast<double>(needed), 1e-9 * static_cast<double>(available));
}

}  // namespace ulf::render
