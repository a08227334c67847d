// Detects pictures that no single lens made, by metadata: panoramas (XMP of Photo Sphere), stereo pairs (JPS,
// XMP, the Multi-Picture Format of CIPA DC-007), and pixels that are not square.
#pragma once

#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// These throw an Error that begins with `name` and says the remedy if the picture is a panorama or a stereo
// pair, by its XMP text or by the segments of a JPEG. Further pictures in the JPEG become a remark.
void RequireOneLens(std::string_view xmp, const std::string& name);
void RequireOneLensOfJpeg(std::string_view jpeg, const std::string& name, StoredPicture& picture);

// Warns if the resolutions across and down, in any unit, say that pixels are not square; zeros say nothing.
void WarnOfPixelAspect(double across, double down, StoredPicture& picture);

// Says, for errors, what makes perspective pictures of a panorama: of a whole sphere in the equirectangular
// projection, a command that writes `out`.
std::string PanoramaRemedy(bool is_whole_sphere, const char* out = "OUT.png");

// Says, for errors, how to take the pictures of one eye out of stereo pairs.
enum class StereoLayout { kSideBySide, kOverUnder, kOther };
std::string StereoPairRemedy(StereoLayout layout);

}  // namespace ulf
