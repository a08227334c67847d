// Reads and writes the rarer kinds of picture files; png_picture.h and jpeg_codec.h have the common ones.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// These read BMP through FFmpeg's libavcodec, Netpbm (PBM, PGM, PPM, PNM through libavcodec, PFM here) and
// Radiance HDR through stb. They throw an Error that begins with `name` if the bytes are damaged or
// truncated. The pixels of PFM and HDR are linear light.
StoredPicture ReadBmp(std::string_view bytes, const std::string& name);
StoredPicture ReadNetpbm(std::string_view bytes, const std::string& name);
StoredPicture ReadRadiance(std::string_view bytes, const std::string& name);

// Reads a TIFF of any layout (TIFF 6.0, BigTIFF, Adobe's supplements) through libtiff: in strips or tiles,
// chunky or in planes, integers of 1 to 16 and of 32 bits, floats of 16, 24, 32 or 64, black or white at
// zero, palettes, inks, YCbCr, CIE L*a*b* and LogLuv. Takes the first page that is no thumbnail and converts
// it to sRGB by its ICC profile; floats without a profile are linear light. The mark of orientation is not
// applied. Throws an Error that names the file if it is damaged or holds no picture.
StoredPicture ReadTiff(const std::string& path);

// Reads a WebP (RFC 9649) through libwebp and converts it to sRGB by the ICC profile. Throws an Error that
// begins with `name` if the file is damaged, truncated or animated.
StoredPicture ReadWebp(std::string_view bytes, const std::string& name);

// These read a WebP's size and alpha from its first 256 bytes; none and false if they are damaged.
std::optional<cv::Size2d> WebpSize(std::string_view begin);
bool WebpHasAlpha(std::string_view begin);

// Encodes 8-bit pixels, B G R or B G R A; quality 1 to 100. Throws Error for other pixels.
std::string WebpBytes(const cv::Mat& pixels, int quality);

}  // namespace ulf
