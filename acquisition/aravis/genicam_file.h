// Reads a camera's GenICam description (XML) from disk, without the camera.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

struct GenicamFile {
  std::string vendor, model;
  std::size_t features = 0;                // number of values and commands
  std::vector<std::string> pixel_formats;  // by their names in the description
  FeatureNames names;
};
// Throws Error for a file that Aravis does not read.
GenicamFile ReadGenicamFile(const std::filesystem::path& file);

}  // namespace ulf::acquisition
