// CIELAB and the colour difference CIEDE2000.
//
// Light is linear sRGB (Rec. 709 primaries, white D65, where 1 is white). L*a*b* is relative to white D50, as
// the published colours of charts are; Bradford's adaptation converts between the two.
#pragma once

#include <Eigen/Core>

namespace ulf {

// These convert R G B to L* a* b*, and back.
Eigen::Vector3d LabFromLinearSrgb(const Eigen::Vector3d& rgb);
Eigen::Vector3d LinearSrgbFromLab(const Eigen::Vector3d& lab);

// CIEDE2000 with kL = kC = kH = 1 (Sharma, Wu and Dalal 2005, "The CIEDE2000 color-difference formula:
// implementation notes"). 1 is about what an eye just tells apart.
double ColorDifference2000(const Eigen::Vector3d& lab_a, const Eigen::Vector3d& lab_b);

}  // namespace ulf
