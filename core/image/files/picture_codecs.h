// Kinds of picture files that are read and written each through a library of its own; png_picture.h and
// jpeg_codec.h have the common ones.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// The rarer kinds of pictures: BMP and Netpbm (PBM, PGM, PPM, PNM) through FFmpeg's libavcodec, Radiance HDR
// through stb, PFM.

// Throw Error, which begins with `name`, where the bytes are damaged or cut.
StoredPicture ReadBmp(std::string_view bytes, const std::string& name);
StoredPicture ReadNetpbm(std::string_view bytes, const std::string& name);
// Linear light.
StoredPicture ReadRadiance(std::string_view bytes, const std::string& name);

// TIFF pictures of any layout (TIFF 6.0, BigTIFF, Adobe's supplements), through libtiff: in strips or tiles,
// chunky or in planes, of whole numbers of 1 to 16 and of 32 bits or of floating point of 16, 24, 32 or 64,
// black or white at zero, palettes, inks, YCbCr, CIE L*a*b* and LogLuv.

// The first page that is no thumbnail, converted to sRGB by its ICC profile; floating point is linear light
// unless that says otherwise. The mark of orientation is not applied. Throws Error, which names the file,
// where it is damaged, or holds what is no picture.
StoredPicture ReadTiff(const std::string& path);

// WebP pictures (RFC 9649), through libwebp.

// Converted to sRGB by its ICC profile. Throws Error, which begins with `name`, where the file is damaged,
// cut or animated.
StoredPicture ReadWebp(std::string_view bytes, const std::string& name);

// From its first bytes.
bool WebpHasAlpha(std::string_view begin);

// Of 8 bits, B G R or B G R A; quality 1 to 100.
std::string WebpBytes(const cv::Mat& pixels, int quality);

}  // namespace ulf
