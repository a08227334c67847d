// WebP pictures (RFC 9649), through libwebp.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Converted to sRGB by its ICC profile. Throws Error, which begins with `name`, where the file is damaged, cut or animated.
StoredPicture ReadWebp(std::string_view bytes, const std::string& name);

// From its first bytes.
bool WebpHasAlpha(std::string_view begin);

// Of 8 bits, B G R or B G R A; quality 1 to 100.
std::string WebpBytes(const cv::Mat& pixels, int quality);

}  // namespace ulf
