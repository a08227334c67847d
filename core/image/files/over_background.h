// Pictures with alpha, laid over a colour.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace ulf {

// The picture's colours (straight, not premultiplied) over `background` (B, G, R, display-encoded, 0 to 1), by the
// numbers as they are stored, which is how synthetic sets for view synthesis are meant: CV_8UC3 or CV_16UC3. Empty
// where the file has no alpha channel. Throws Error as ReadImageFile() does.
cv::Mat ReadOverBackground(const std::string& path, const cv::Vec3d& background);

}  // namespace ulf
