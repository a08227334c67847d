// Detects pictures that no single lens made, by what cameras and programs write beside the pixels: panoramas
// (XMP of Photo Sphere), stereo pairs (JPS, XMP, the Multi-Picture Format of CIPA DC-007), and pixels that
// are not square.
#pragma once

#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Both throw Error, which begins with `name` and says the remedy, for such a picture.
void RequireOneLens(std::string_view xmp, const std::string& name);
// Reads the segments of a JPEG; further pictures behind the first become a remark.
void RequireOneLensOfJpeg(std::string_view jpeg, const std::string& name, StoredPicture& picture);

// Warns if the resolutions across and down say that pixels are not square; zeros say nothing.
void WarnOfPixelAspect(double across, double down, StoredPicture& picture);

// Says, for errors, what makes perspective pictures of a panorama: for a whole sphere, height by azimuth, a
// command that writes `out`.
std::string PanoramaRemedy(bool is_whole_sphere, const char* out = "OUT.png");

enum class StereoLayout { kSideBySide, kOverUnder, kOther };
std::string StereoPairRemedy(StereoLayout layout);

}  // namespace ulf
