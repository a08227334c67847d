// Text of a lens file that speaks of a fisheye or of an omnidirectional lens under a key, or in a wording, that
// lens_words.h does not take as the model's word. Such a lens must not be taken silently as k1 k2 p1 p2.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_tree.h"
#include "acquisition/calibration/lens_files/lens_words.h"

namespace ulf::acquisition {

// `part`: what the file says of the camera, at any depth. Where `said` is none, throws Error that begins with `where`,
// quotes key and value, and tells to add `lines`; names of cameras, topics and files are appended to `warnings` instead.
// Where there is a word, it decides: text that speaks of another model is a warning, names are left alone.
void CheckLensMentions(const LensNode& part, const std::optional<SaidLensModel>& said,
                       const std::string& lines, const std::string& where,
                       std::vector<std::string>& warnings);

}  // namespace ulf::acquisition
