#include "render/display/shapes.h"

#include <algorithm>
#include <cmath>

namespace ulf::render {

Rgba Rgba::WithOpacity(double opacity) const {
  return {r, g, b, static_cast<std::uint8_t>(std::lround(a * std::clamp(opacity, 0.0, 1.0)))};
}

Rgba Mix(const Rgba& from, const Rgba& to, double share) {
  const auto mix = [share = std::clamp(share, 0.0, 1.0)](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround((1 - share) * a + share * b));
  };
  return {mix(from.r, to.r), mix(from.g, to.g), mix(from.b, to.b), mix(from.a, to.a)};
}

}  // namespace ulf::render
