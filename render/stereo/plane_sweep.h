// Estimates the depth of a view by sweeping planes through space (Collins 1996). Every plane is parallel to
// the image and maps the neighbouring photographs into it; agreement indicates a surface. Planes are evenly
// spaced in inverse depth.
//
// The cost of a plane at a pixel is 1 - ZNCC (zero-mean normalised cross-correlation) over a small window,
// truncated; ZNCC does not depend on exposure. The cost is the mean over the better half of the neighbours,
// because the others may see an occluder. In a window without texture every plane costs the same. Semi-global
// matching (Hirschmueller 2008) chooses planes, and a parabola through costs gives the depth between them.
//
// Most planes are far from every surface. SweepPlanes() therefore sweeps at half the size first, and then
// compares in each tile of the image only planes near those that were chosen by a pixel of the tile or its
// surroundings, or preferred by a few together; all others cost as much as no agreement.
#pragma once

#include <atomic>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "render/stereo/semi_global.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct InverseDepthRange {
  double least = 0, most = 0;  // 1 / (depth along the optical axis)
  int planes = 0;
  // Returns the inverse depth of a plane (the first is 0), or between two.
  double At(double plane) const { return least + (most - least) * plane / (planes - 1); }
};

struct SweepOptions {
  int window_radius_px = 2;  // 1 to 3. Guessed.
  // Standard deviation of grey values in a window below which its texture counts as noise. Guessed.
  double noise = 2.0;
  double truncation = 1.0;   // of 1 - ZNCC: a worse match costs no more. Guessed.
  double small_step = 0.10;  // cost of a change by one plane. Guessed.
  double large_step = 0.90;  // cost of a larger change at constant grey value. Guessed.
  double edge_grey = 12;     // a change of the grey value that halves the cost of a larger change. Guessed.
  // Settled on fern of LLFF and fox_half (decibels), the simulated plant, and a simulated post of six pixels
  // before a wall (stereo_test). A view whose longer side has fewer pixels is swept in full; 0: every view.
  int coarse_from_px = 400;
  int tile_px = 16;  // of the image; larger ones take planes that few of their pixels need
  const std::atomic<bool>* given_up = nullptr;  // once true, SweepPlanes() soon returns empty matrices
};

struct DepthMap {
  cv::Mat depth;      // CV_32F, along the optical axis, world units; 0: none
  cv::Mat agreement;  // CV_32F, 0 to 1: ZNCC at this depth over the better half of the neighbours
};

// The homography from a view's image to a neighbour's by a plane that is parallel to the view's image:
// (at_infinity + inverse_depth * [0 0 per_inverse_depth]) (x, y, 1), up to scale; pixels to pixels.
struct PlaneCarrier {
  Eigen::Matrix3f at_infinity;
  Eigen::Vector3f per_inverse_depth;
};
PlaneCarrier MakePlaneCarrier(const StereoView& view, const StereoView& neighbour);

// The planes that are compared, for each tile of the image.
class PlanesOfTiles {
 public:
  PlanesOfTiles(const cv::Size& image, int tile_px, int planes);
  int tile_px() const { return tile_px_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  bool Has(int column, int row, int plane) const { return has_[Index(column, row, plane)] != 0; }
  void Add(int column, int row, int first_plane, int last_plane);  // clamps to existing planes
  double Share() const;                                            // of all planes of all tiles

 private:
  std::size_t Index(int column, int row, int plane) const {
    return (static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
            static_cast<std::size_t>(column)) *
               static_cast<std::size_t>(planes_) +
           static_cast<std::size_t>(plane);
  }
  int tile_px_, columns_, rows_, planes_;
  std::vector<std::uint8_t> has_;
};

// Returns the planes of `range` that are near a surface, by the same sweep at half the size.
PlanesOfTiles PlanesNearSurfaces(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                                 const InverseDepthRange& range, const SweepOptions& options = {});

// Returns the cost of each plane at each pixel, in 8 bits; on the processor. Null `compared`: all planes.
CostVolume MatchingCosts(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                         const InverseDepthRange& range, const SweepOptions& options = {},
                         const PlanesOfTiles* compared = nullptr);
// Returns the size of the better half of this number of neighbours; at most 16.
int KeptNeighbours(std::size_t neighbours);
constexpr float kCostUnit = 80;  // 8-bit units for a cost of 1: the largest, 2, still fits
std::uint8_t CostByte(float cost);

// Chooses the planes. Masked pixels, and those of least cost at an end of the range, have no depth.
DepthMap DepthOfLeastCost(const CostVolume& volume, const StereoView& view, const InverseDepthRange& range,
                          const SweepOptions& options = {});
// Runs MatchingCosts(), for all planes or for those near surfaces, and DepthOfLeastCost().
DepthMap SweepPlanes(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                     const InverseDepthRange& range, const SweepOptions& options = {});

}  // namespace ulf::render
