// PNG pictures (ISO 15948), through libpng.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Converted to sRGB by what the file says of its colours: cICP before iCCP, sRGB, gAMA and cHRM (PNG, third
// edition). Throws Error, which begins with `name`, where the file is damaged, or of a high dynamic range.
StoredPicture ReadPng(std::string_view bytes, const std::string& name);

// 8 or 16 bits; one channel, B G R, or B G R A. Fast rather than small.
std::string PngBytes(const cv::Mat& pixels);

}  // namespace ulf
