// Finds the poses of photographs in any order through the program COLMAP, which must be installed (3.8, as
// Debian's package colmap, to 4). It works on the processors alone.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/light_field/exchange/staged_folder.h"

namespace ulf {

struct PosedByColmap {
  // The largest model; its images have the names of the photographs, in a folder each.
  std::filesystem::path model;
  std::size_t photographs = 0;  // that COLMAP was given
  std::size_t posed = 0;        // of these in the model
  std::vector<std::string> doubts;
  std::unique_ptr<StagedFolder> work;  // holds the model, and is removed with this object
};

// Poses the photographs in `folder` itself. Those of the same size, camera, lens and focal length share one
// camera, whose focal length Exif tells where it can. No features are taken where masks (SetImages::MaskOf(),
// DynamicMaskOf()) or alpha exclude them. Up to 150 photographs are all compared with each other;
// more are compared along their order, by time or else by name, and then where a third photograph joins two.
// The working folder lies beside `dir`, the light field to be made, which must not exist or be empty. `stop`,
// which is asked several times a second, ends the work. Throws Error if COLMAP is not installed or fails (the
// working folder then stays, and is named with COLMAP's last lines), if it finds no poses, if there are fewer
// than two photographs, and when stopped.
PosedByColmap PoseByColmap(const std::filesystem::path& folder, const std::filesystem::path& dir,
                           const std::function<bool()>& stop);

}  // namespace ulf
