// Reads lens files that hold a camera matrix and distortion coefficients: OpenCV's storage, ROS's camera_info
// as file, as echo of its topic and as ost.ini, and what scripts write. All have pixel centres at integers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// Returns whether any map down to the second level holds a camera matrix.
bool HasCameraMatrix(const LensNode& top);
// Returns whether the keys are those of ROS's camera_info.
bool IsRosLens(const LensNode& top);

// Returns the lens of a document, or of several equal ones; of several cameras (K1 K2, left right, sections,
// unequal documents) the wanted one (PickLens()). `may_be_cut`: the syntax does not show where the text ends,
// as JSON and XML do. Throws Error that begins with `where`.
Lens ReadMatrixLens(const std::vector<LensNode>& documents, const std::string& where,
                    const std::string& wanted, bool may_be_cut = true);

// The following read lenses without a camera matrix, in pixels: fx fy cx cy as separate keys, or two lists,
// of focal lengths and of the principal point, as okvis, RealSense, telephones and many scripts write them.

// The key of a matrix made of such numbers.
inline constexpr const char* kPlainMatrixKey = "fx fy cx cy";

// Returns the tree with a camera matrix added to each map that has such numbers and no matrix.
LensNode WithCameraMatrices(const LensNode& top);

// Reads distortion from keys k1, k2, p1, ... of the map, or of a map in it whose key mentions distortion.
// Returns the coefficients in OpenCV's order for the model `numbers.named`; none if there are no such keys.
// Throws Error that begins with `where` for keys of another model, or others than zeros without a model.
std::optional<std::vector<double>> PlainCoefficients(const LensNode& map, const LensNumbers& numbers,
                                                     const std::string& where);

}  // namespace ulf::acquisition
