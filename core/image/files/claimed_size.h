// The size that pictures of the rarer kinds claim: BMP, Netpbm (PBM to PPM, PFM), Radiance HDR and WebP. image_header.h reads
// more of the common ones.
#pragma once

#include <iosfwd>
#include <opencv2/core.hpp>
#include <optional>

namespace ulf {

// As the file says, unchecked; none: another kind, or truncated.
std::optional<cv::Size2d> ClaimedSize(std::istream& file);

}  // namespace ulf
