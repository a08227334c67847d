// Keys of scripts' lens files: words for the same thing, alone or with one of several cameras' marks before
// or behind them, as K1, cameraMatrixL, LEFT.K.
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

// Words as LensWord() makes them.
extern const std::span<const std::string_view> kMatrixKeys;
extern const std::span<const std::string_view> kCoefficientKeys;

// A key's word, and the camera's mark: "k" and "1" of K1, "k" and "left" of LEFT.K.
struct MarkedKey {
  std::string_view base;
  std::string mark;  // empty: none
};

// None: another key.
std::optional<MarkedKey> MarkedAs(const std::string& key, std::span<const std::string_view> bases);

// The value behind the key that has the mark and passes the test; null: there is none. Throws Error that
// begins with `where` for two such keys with different values.
std::pair<std::string, const LensNode*> FindMarked(const LensNode& map,
                                                   std::span<const std::string_view> bases,
                                                   const std::string& mark, const std::string& where,
                                                   const std::function<bool(const LensNode&)>& test);

// The marks of the camera matrices in a map, the empty one for a matrix without a mark.
std::vector<std::string> MarksOfMatrices(const LensNode& map);

}  // namespace ulf::acquisition
