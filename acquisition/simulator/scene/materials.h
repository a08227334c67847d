// What the scenes' surfaces are painted with: reflectances (linear B, G, R, 0 to 1) as functions of a point
// on the solid, in metres of its own frame. Every pattern is scattered by hashes over the whole surface: rich
// in corners at several scales, and nowhere repeating, so that a place can be told from every other.
#pragma once

#include "acquisition/simulator/scene/lanes.h"
#include "acquisition/simulator/scene/primitive.h"
#include "core/fiducials/board.h"

namespace ulf::acquisition {

// The sheet of kMarkerSheet: its board, with a white rim around it.
struct MarkerSheet {
  static Board PrintedBoard();
  static constexpr double kRimMm = 15;
  static double WidthM() { return 0.001 * (PrintedBoard().WidthMm() + 2 * kRimMm); }
  static double HeightM() { return 0.001 * (PrintedBoard().HeightMm() + 2 * kRimMm); }
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
};
}

struct PaintedPoint {
  Eigen::Vector3f local;
  float u_m, v_m;  // along the chart
  int chart;
  float texel_m;  // edges are softened over this width
};

F4 Reflectance(int material, const PaintedPoint& point);

}  // namespace ulf::acquisition
