// Seeded problems on a grid of geometry, noise and outliers, and what a solver makes of them inside the
// product's sampler (tracking/estimation/sampling.h); nothing else differs. One camera's pose is refined on
// its inliers as the product does it; two views are not refined, so that the solver alone is seen.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/charts/solvers.h"

namespace ulf::test {

struct Geometry {
  const char* name;
  int inliers;               // outliers come on top
  double nearest, farthest;  // depths
  double relief;             // of a tilted plane; below zero: no plane
  double baseline;           // two views
  bool forward = false;      // two views: along the axis
};

inline constexpr std::array kAbsoluteGeometries{
    Geometry{"deep", 100, 2, 8, -1, 0}, Geometry{"planar", 100, 4, 4, 0, 0},
    Geometry{"near-planar", 100, 4, 4, 0.04, 0}, Geometry{"far", 100, 40, 60, -1, 0},
    Geometry{"few points", 8, 2, 8, -1, 0}};

inline constexpr std::array kRelativeGeometries{
    Geometry{"deep", 100, 2, 7, -1, 0.3},          Geometry{"planar", 100, 4, 4, 0, 0.3},
    Geometry{"near-planar", 100, 4, 4, 0.04, 0.3}, Geometry{"far", 100, 20, 30, -1, 0.3},
    Geometry{"few points", 12, 2, 7, -1, 0.3},     Geometry{"small baseline", 100, 2, 7, -1, 0.08},
    Geometry{"forward", 100, 2, 7, -1, 0.3, true}};

struct Trials {
  double noise_px = 0.5;
  double outliers = 0;  // share
  int count = 20;
  unsigned seed = 1;
  int max_iterations = 500;  // samples drawn at most, as in the product
};

struct Outcome {
  double ms = 0;        // CPU, mean
  double failures = 0;  // share
  // Medians of all trials, infinite where half of them found nothing.
  double rotation_deg = 0;
  double position = 0;  // one camera: % of the nearest depth; two views: degrees between the directions
};

// Error: how far the scene's points land from where they should, px RMS; a failure beyond 3 px plus twice the
// noise.
Outcome RunTrials(const Geometry& geometry, const AbsoluteSolver& solver, const Trials& trials);
// Error: the larger one of the rotation's and the translation's direction, degrees; a failure beyond 10.
Outcome RunTrials(const Geometry& geometry, const EssentialSolver& solver, const Trials& trials);

// The solver alone on single samples, without noise: how often none of its solutions is the truth, and the
// CPU time of a call. A success reproduces it to a thousandth.
struct Alone {
  double us = 0;
  double misses = 0;  // share
};
Alone RunAlone(const Geometry& geometry, const AbsoluteSolver& solver, int count, unsigned seed);
Alone RunAlone(const Geometry& geometry, const EssentialSolver& solver, int count, unsigned seed);

}  // namespace ulf::test
