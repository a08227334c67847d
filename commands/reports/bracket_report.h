// Merges the exposures of all views of a light field, for `ulf merge` and the end of `ulf capture --bracket`.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace ulf::commands {

struct BracketReport {
  std::size_t views = 0;      // merged now
  std::size_t exposures = 0;  // that went into them
  std::size_t left_out = 0;   // exposures whose light is not what their time tells
  double stops = 0;           // the longest over the shortest exposure, most
  std::string geometry;       // by which exposures were aligned: a proxy's name
  // Of the merged views: shares of their pixels.
  double ghosts_median = 0, ghosts_most = 0;
  int ghosts_most_view = 0;
  double clipped_most = 0;
  // Of any exposure, by how the camera moved during it.
  double blur_most_px = 0;
  int blur_most_view = 0;
};

// Nothing where no view has other exposures. Throws Error.
BracketReport MergeBrackets(const std::filesystem::path& light_field);

std::string ToText(const BracketReport& report);
nlohmann::json ToJson(const BracketReport& report);

}  // namespace ulf::commands
