// The rarer kinds of pictures: BMP and Netpbm (PBM, PGM, PPM, PNM) through FFmpeg's libavcodec, Radiance HDR through stb, PFM.
#pragma once

#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Throw Error, which begins with `name`, where the bytes are damaged or cut.
StoredPicture ReadBmp(std::string_view bytes, const std::string& name);
StoredPicture ReadNetpbm(std::string_view bytes, const std::string& name);
// Linear light.
StoredPicture ReadRadiance(std::string_view bytes, const std::string& name);

}  // namespace ulf
