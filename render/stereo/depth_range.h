// Finds the range of depths over which a view's planes are swept.
#pragma once

#include <atomic>
#include <vector>

#include "render/stereo/plane_sweep.h"

namespace ulf::render {

struct DepthRangeOptions {
  // Limit of the longer side of the first sweep's views, which is never more than half of the views'.
  // Guessed.
  int size_px = 320;
  // SweepOptions::coarse_from_px of the first sweep. Settled on fern of LLFF and fox_half.
  int coarse_from_px = 160;
  // The first sweep's range, in distances to the subject. Guessed.
  double nearest = 0.2, farthest = 100;
  // The first sweep must give at least this many sure depths, otherwise its own range is returned. Guessed.
  std::size_t fewest = 100;
  // Share of these depths that is cut off at either end, as outliers. Guessed.
  double left_out = 0.005;
  // The range is extended at either end by this share of itself, and this share of the largest inverse depth.
  // Guessed.
  double margin = 0.1, margin_of_most = 0.02;
  const std::atomic<bool>* given_up = nullptr;  // once true, FindRange() soon returns its first range
};

// Returns the range for a view. A first sweep at a small size over a wide range finds the depths; the planes
// of the result are those of PixelSpacedRange(). `subject_distance` is in world units.
InverseDepthRange FindRange(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                            double subject_distance, const DepthRangeOptions& options = {});

// Limits of InverseDepthRange::planes: fewer give no minimum, more take too long. Guessed.
inline constexpr int kFewestPlanes = 16, kMostPlanes = 256;

// Returns the range from `nearest` to `farthest` (world units). From plane to plane the middle of the image
// moves by about a pixel in the neighbour where it moves most.
InverseDepthRange PixelSpacedRange(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                                   double nearest, double farthest);

// Returns the change of depth at `distance` that moves a point by one pixel in the neighbour where it moves
// most; infinite if it moves in none.
double DepthStepOfPixel(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                        double distance);

}  // namespace ulf::render
