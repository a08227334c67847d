// Recognises keys in lens files that users' scripts write: one of several words for camera matrix or
// coefficients, alone or with the mark of one of several cameras: K1, cameraMatrixL, LEFT.K.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// The words for a camera matrix and for distortion coefficients, normalised by LensWord().
extern const std::span<const std::string_view> kMatrixKeys;
extern const std::span<const std::string_view> kCoefficientKeys;

// A key split into its word and the camera's mark: K1 into "k" and "1", LEFT.K into "k" and "left".
struct MarkedKey {
  std::string_view base;
  std::string mark;  // empty: none
};

// Splits a key whose word is one of `bases`; none for any other key.
std::optional<MarkedKey> MarkedAs(const std::string& key, std::span<const std::string_view> bases);

// Returns the key of `bases` that has the mark and whose value passes the test, and its value; null if none.
// Throws Error that begins with `where` for two such keys with different values.
std::pair<std::string, const LensNode*> FindMarked(const LensNode& map,
                                                   std::span<const std::string_view> bases,
                                                   const std::string& mark, const std::string& where,
                                                   const std::function<bool(const LensNode&)>& test);

// Returns the marks of the camera matrices in a map; the mark is empty for a matrix without one.
std::vector<std::string> MarksOfMatrices(const LensNode& map);

}  // namespace ulf::acquisition
