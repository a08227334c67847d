// A colour chart of 24 patches (4 rows of 6, as the ColorChecker Classic), with the published colours and the
// places of its patches. Patches count from 0, the dark brown one, row by row, as the maker's list does; the
// last row goes from white to black.
#pragma once

#include <Eigen/Core>
#include <array>

namespace ulf {

inline constexpr int kChartColumns = 6, kChartRows = 4, kChartPatches = 24;
inline constexpr int kFirstGrey = 18;  // index of the white patch; the greys follow

// Returns L* a* b* (D50) as published for charts made before November 2014; later ones differ by less than 3.
const std::array<Eigen::Vector3d, kChartPatches>& ChartLab();

// The chart's outline is a rectangle of this size, in the units of OpenCV's model (mcc), with square patches.
// PatchCenter() is from the upper left corner, x to the right, y down.
inline constexpr double kChartWidth = 16.75, kChartHeight = 11.25, kPatchWidth = 2.5, kPatchGap = 0.25;
Eigen::Vector2d PatchCenter(int patch);

}  // namespace ulf
