// Reads lens files that hold a camera matrix and distortion coefficients: OpenCV's storage, ROS's camera_info
// as file, as echo of its topic and as ost.ini, and what scripts write with the same words. All have pixel
// centres at integers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// Returns whether any map down to the second level holds a camera matrix.
bool HasCameraMatrix(const LensNode& top);
// Returns whether the words are ROS's.
bool IsRosLens(const LensNode& top);

// Returns the lens of a document, or of equal ones; of several cameras (K1 K2, left right, sections, unequal
// documents) the wanted one. `may_be_cut`: the text has no end of its own, as JSON and XML have. Throws Error
// that begins with `where`.
Lens ReadMatrixLens(const std::vector<LensNode>& documents, const std::string& where,
                    const std::string& wanted, bool may_be_cut = true);

// The following read lenses without a camera matrix, in pixels: fx fy cx cy as separate keys, or a list of
// focal lengths and one for the principal point, as okvis, RealSense's and telephones' programs and many
// scripts write them.

// The key of a matrix made of such numbers.
inline constexpr const char* kPlainMatrixKey = "fx fy cx cy";

// Returns the tree, in which each map with such numbers and no camera matrix has one.
LensNode WithCameraMatrices(const LensNode& top);

// Reads distortion from keys k1, k2, p1, ... of the map, or of a map in it whose key mentions distortion, in
// OpenCV's order; none: there are no such keys. `numbers.named` decides the order. Throws Error that begins
// with `where` where there is no word for the model and they are not all zero, and for keys that do not
// belong to it.
std::optional<std::vector<double>> PlainCoefficients(const LensNode& map, const LensNumbers& numbers,
                                                     const std::string& where);

}  // namespace ulf::acquisition
