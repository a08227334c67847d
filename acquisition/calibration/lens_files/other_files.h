// Files of programs whose lenses ulf does not read, recognised so that a refusal names the program and the way out
// instead of a fault that is none.
#pragma once

#include <optional>
#include <string>

#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// What the file is and what to do, as the end of a sentence that begins with the file's name: "is ...; ...". None: it is
// unknown. The first looks at the text before it is parsed, which may not be possible.
std::optional<std::string> OtherLensText(const std::string& text);
std::optional<std::string> OtherLensTree(const LensNode& top);

}  // namespace ulf::acquisition
