// Lens files that hold a camera matrix and distortion coefficients: OpenCV's storage, ROS's camera_info as file, as echo
// of its topic and as ost.ini, and what scripts write with the same words. All have pixel centres at integers.
#pragma once

#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// Whether any map down to the second level holds a camera matrix.
bool HasCameraMatrix(const LensNode& top);
// Whether the words are ROS's.
bool IsRosLens(const LensNode& top);

// The lens of a document, or of equal ones; of several cameras (K1 K2, left right, sections, unequal documents) the
// wanted one. `may_be_cut`: the text has no end of its own, as JSON and XML have. Throws Error that begins with `where`.
Lens ReadMatrixLens(const std::vector<LensNode>& documents, const std::string& where,
                    const std::string& wanted, bool may_be_cut = true);

}  // namespace ulf::acquisition
