// Defines procedural materials: reflectance (linear B, G, R, 0 to 1) as a function of a point on the solid,
// in metres in the solid's frame. Hashes scatter every pattern over the whole surface, so that it has corners
// at several scales and never repeats: features can be matched uniquely (but kStucco has none).
#pragma once

#include "acquisition/simulator/scene/lanes.h"
#include "acquisition/simulator/scene/primitive.h"
#include "core/fiducials/board.h"

namespace ulf::acquisition {

// The sheet of kMarkerSheet or kTurntableSheet: a board with a white rim.
struct MarkerSheet {
  static const Board& BoardOf(int material);
  static constexpr double kRimMm = 15;
  static double WidthM(const Board& board) { return 0.001 * (board.WidthMm() + 2 * kRimMm); }
  static double HeightM(const Board& board) { return 0.001 * (board.HeightMm() + 2 * kRimMm); }
};

namespace material {
enum Name : int {
  kTerrazzo,     // table top
  kFieldstone,   // wall
  kPlaster,      // the rest of the room
  kMosaic,       // plinth
  kMarbled,      // large sphere
  kGlaze,        // glossy sphere
  kPrinted,      // carton
  kLabel,        // can
  kPatchwork,    // cone
  kBanded,       // torus
  kRedTerrazzo,  // small sphere
  kPosters,      // the flat scene's wall
  kMarkerSheet,  // the marker board on the easel, on the box's face towards -y
  kStucco,       // one pale colour, all but without texture
  kPorcelain,    // white with blue strokes
  kLeaf,
  kBark,
  kWood,            // boards
  kPainting,        // brush strokes over a landscape
  kTurntableSheet,  // the marker board on the turntable, on the box's face towards -y
};
}

struct PaintedPoint {
  Eigen::Vector3f local;  // metres, the solid's frame
  float u_m, v_m;         // metres along the chart's sides
  int chart;
  float texel_m;  // edges are softened over this width
};

F4 Reflectance(int material, const PaintedPoint& point);

}  // namespace ulf::acquisition
