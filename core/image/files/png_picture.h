// Reads and writes PNG pictures (ISO 15948) through libpng.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Converts to sRGB by the file's colour chunks, with precedence cICP, iCCP, sRGB, gAMA and cHRM (PNG, third
// edition). Throws an Error that begins with `name` if the file is damaged, has a high dynamic range, or is a
// panorama or a stereo pair.
StoredPicture ReadPng(std::string_view bytes, const std::string& name);

// Encodes 8 or 16 bits, one channel, B G R or B G R A; fast rather than small. Throws Error for others.
std::string PngBytes(const cv::Mat& pixels);

// Converts linear light (CV_32FC3, clamped to 0..1) to the pixels of a PNG of 16 bits: CV_16UC3, sRGB.
cv::Mat Srgb16FromLinear(const cv::Mat& linear);

}  // namespace ulf
