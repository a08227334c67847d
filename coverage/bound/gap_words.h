// Describes where a cap is still open, for somebody who sees no map: "one large gap: right half, 7° right and
// 3° up of the first view".
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "coverage/bound/coverage_map.h"

namespace ulf::coverage {

// A hole of a coverage map (CoverageHole) in degrees.
struct CapGap {
  double area_deg2 = 0;                       // square degrees
  double azimuth_deg = 0, elevation_deg = 0;  // of its middle, to the right and up from the first view
};

// Returns the gaps, the largest first; empty before the first view.
std::vector<CapGap> GapsOf(const CoverageMap& map);

// Returns "7° right and 3° up of the first view"; `degree`: "°", or what a font has for it.
std::string PlaceInWords(const CapGap& gap, const char* degree = "°");

// Returns words for a single gap as above, or else the number of gaps, their share of the cap, and the place
// of the largest; empty without gaps.
std::string InWords(const std::vector<CapGap>& gaps, const Cap& cap, const char* degree = "°");

}  // namespace ulf::coverage
