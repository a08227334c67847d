// What a picture's pixels are to a lens. Pictures that no single lens made, told by what cameras and programs
// write beside the pixels: panoramas (XMP of Photo Sphere) and stereo pairs (JPS, XMP, the Multi-Picture
// Format of CIPA DC-007). And pixels that are not square.
#pragma once

#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Both throw Error, which begins with `name` and says the way out, of such a picture.
void RequireOneLens(std::string_view xmp, const std::string& name);
// By the segments of a JPEG; further pictures that lie behind the first are a remark.
void RequireOneLensOfJpeg(std::string_view jpeg, const std::string& name, StoredPicture& picture);

// Warns where numbers of pixels to a length, across and down, say that pixels are not square; zeros say
// nothing.
void WarnOfPixelAspect(double across, double down, StoredPicture& picture);

// What makes perspective pictures of a panorama, in words for errors: of a whole sphere, height by azimuth, a
// command that writes `out`.
std::string WayFromPanorama(bool is_whole_sphere, const char* out = "OUT.png");

enum class StereoLayout { kSideBySide, kOverUnder, kOther };
std::string WayFromStereoPair(StereoLayout layout);

}  // namespace ulf
