// What a picture's pixels are to a lens. Pictures that no single lens made, told by what cameras and programs write beside the pixels: panoramas (XMP of Photo Sphere) and
// stereo pairs (JPS, XMP, the Multi-Picture Format of CIPA DC-007). And pixels that are not square.
#pragma once

#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

// Both throw Error, which begins with `name` and says the way out, of such a picture.
void RequireOneLens(std::string_view xmp, const std::string& name);
// By the segments of a JPEG; further pictures that lie behind the first are a note.
void RequireOneLensOfJpeg(std::string_view jpeg, const std::string& name, StoredPicture& picture);

// Warns where numbers of pixels to a length, across and down, say that pixels are not square; zeros say nothing.
void WarnOfPixelAspect(double across, double down, StoredPicture& picture);

// What makes perspective pictures of a panorama, and of a stereo pair, in words for errors.
inline constexpr const char* kFromPanorama =
    "make perspective pictures of it, for instance with 'ffmpeg -i IN -vf "
    "v360=e:flat:h_fov=90:v_fov=90:w=1500:h=1500:yaw=0 OUT.png'";
inline constexpr const char* kFromStereoPair =
    "give the pictures of one eye, for instance by 'ffmpeg -i IN -vf crop=iw/2:ih:0:0 OUT' where they lie "
    "side by side";

}  // namespace ulf
