// Depth of a view by sweeping planes through space (Collins 1996): every plane parallel to the image carries
// the neighbouring photographs over into this one, and where they agree there may be a surface. Planes are
// evenly spaced in inverse depth.
//
// Agreement is 1 - ZNCC over a small window, which does not ask how photographs were exposed, truncated, and
// of the better half of the neighbours, because the others may look at an occluder. Where a window shows no
// texture every plane costs the same. Semi-global matching (Hirschmueller 2008) over the planes decides; a
// parabola through the costs gives the depth between planes.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "render/stereo/semi_global.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct InverseDepthRange {
  double least = 0, most = 0;  // 1 over depth along the optical axis
  int planes = 0;
  double At(double plane) const { return least + (most - least) * plane / (planes - 1); }
};

struct SweepOptions {
  int window_radius_px = 2;
  // Of grey values in a window: less is not told from noise.
  double noise = 2.0;
  double truncation = 1.0;   // of 1 - ZNCC
  double small_step = 0.10;  // penalty for a change by one plane
  double large_step = 0.90;  // by more, in front of no edge of brightness
  double edge_grey = 12;     // a step of brightness that halves it
};

struct DepthMap {
  cv::Mat depth;      // CV_32F, along the optical axis; 0: none
  cv::Mat agreement;  // CV_32F, 0 to 1: ZNCC at this depth of the better half of the neighbours
};

// How badly each plane fits each pixel, 8 bits; on the processor.
CostVolume MatchingCosts(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                         const InverseDepthRange& range, const SweepOptions& options = {});
// Of so many neighbours those that agree best count.
int KeptNeighbours(std::size_t neighbours);
std::uint8_t CostByte(float cost);

DepthMap DepthOfLeastCost(const CostVolume& volume, const StereoView& view, const InverseDepthRange& range,
                          const SweepOptions& options = {});
// Both.
DepthMap SweepPlanes(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                     const InverseDepthRange& range, const SweepOptions& options = {});

}  // namespace ulf::render
