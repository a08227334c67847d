// Reads and writes the picture files that each have a library of their own; png_picture.h and jpeg_codec.h
// have the common kinds.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// The rarer kinds are BMP and Netpbm (PBM, PGM, PPM, PNM) through FFmpeg's libavcodec, Radiance HDR through
// stb, and PFM.

// These throw Error, which begins with `name`, if the bytes are damaged or truncated.
StoredPicture ReadBmp(std::string_view bytes, const std::string& name);
StoredPicture ReadNetpbm(std::string_view bytes, const std::string& name);
// The pixels are linear light.
StoredPicture ReadRadiance(std::string_view bytes, const std::string& name);

// TIFF pictures of any layout (TIFF 6.0, BigTIFF, Adobe's supplements) are read through libtiff: in strips
// or tiles, chunky or in planes, integers of 1 to 16 and of 32 bits, floats of 16, 24, 32 or 64, black or
// white at zero, palettes, inks, YCbCr, CIE L*a*b* and LogLuv.

// Reads the first page that is no thumbnail and converts it to sRGB by its ICC profile; floats are linear
// light unless that says otherwise. The mark of orientation is not applied. Throws Error, which names the
// file, if it is damaged or holds no picture.
StoredPicture ReadTiff(const std::string& path);

// WebP pictures (RFC 9649) are read and written through libwebp.

// Converts to sRGB by the ICC profile. Throws Error, which begins with `name`, if the file is damaged,
// truncated or animated.
StoredPicture ReadWebp(std::string_view bytes, const std::string& name);

// These tell from the file's first bytes; no size if they are damaged.
std::optional<cv::Size2d> WebpSize(std::string_view begin);
bool WebpHasAlpha(std::string_view begin);

// Encodes 8-bit pixels, B G R or B G R A; quality 1 to 100.
std::string WebpBytes(const cv::Mat& pixels, int quality);

}  // namespace ulf
