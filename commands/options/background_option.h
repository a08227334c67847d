// The option `--background` of `ulf import` and `ulf render`.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace ulf::commands {

// "white", "black", or R,G,B from 0 to 255, as B G R from 0 to 1 in display encoding. Throws UsageError.
cv::Vec3d BackgroundFromText(const std::string& text);

}  // namespace ulf::commands
