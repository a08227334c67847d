// TIFF pictures of any layout (TIFF 6.0, BigTIFF, Adobe's supplements), through libtiff: in strips or tiles, chunky or in planes,
// of whole numbers of 1 to 16 and of 32 bits or of floating point of 16, 24, 32 or 64, black or white at zero, palettes, inks,
// YCbCr, CIE L*a*b* and LogLuv.
#pragma once

#include <string>

#include "core/image/files/stored_picture.h"

namespace ulf {

// The first page that is no thumbnail, converted to sRGB by its ICC profile; floating point is linear light unless that says
// otherwise. The mark of orientation is not applied. Throws Error, which names the file, where it is damaged, or holds what is
// no picture.
StoredPicture ReadTiff(const std::string& path);

}  // namespace ulf
