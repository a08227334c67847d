// Shapes that Painter draws over a picture, as values.
//
// Places (`img`) are pixels of the picture, with pixel centres at integer + 0.5. Widths, radii and text sizes
// are in points: pixels of a screen of ordinary density.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace ulf::render {

struct Rgba {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;
  // Multiplies the opacity by `opacity` (0 to 1).
  Rgba WithOpacity(double opacity) const {
    return {r, g, b, static_cast<std::uint8_t>(std::lround(a * std::clamp(opacity, 0.0, 1.0)))};
  }
  bool operator==(const Rgba&) const = default;
};

// Interpolates: `share` 0 gives `from`, 1 gives `to`.
inline Rgba Mix(const Rgba& from, const Rgba& to, double share) {
  const auto mix = [share = std::clamp(share, 0.0, 1.0)](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround((1 - share) * a + share * b));
  };
  return {mix(from.r, to.r), mix(from.g, to.g), mix(from.b, to.b), mix(from.a, to.a)};
}

struct Polyline {
  std::vector<Eigen::Vector2d> img;
  double width = 1;
  Rgba color;
  bool closed = false;
};
// The corners must form a convex polygon.
struct Polygon {
  std::vector<Eigen::Vector2d> img;
  Rgba color;
};
// One of many quadrilaterals side by side, whose edges are not smoothed.
struct Patch {
  std::array<Eigen::Vector2d, 4> img;
  Rgba color;
};
struct Spot {
  Eigen::Vector2d img;
  double radius = 1;
  Rgba color;
};
struct Label {
  Eigen::Vector2d img;
  std::string text;
  double size = 20;
  Rgba color;
  // The point of the text that lies at `img`: 0,0 is its upper left, 1,1 its lower right.
  Eigen::Vector2d anchor{0.5, 0.5};
};
using OverlayShape = std::variant<Polyline, Polygon, Patch, Spot, Label>;
using Overlay = std::vector<OverlayShape>;  // in the order of drawing

}  // namespace ulf::render
