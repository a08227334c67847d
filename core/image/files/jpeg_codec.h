// Reads and writes JPEG pictures through libjpeg, and tells whether one is complete.
//
// A lost USB packet leaves a gap in a webcam's data: the picture is shifted or smeared after it, and nothing
// marks the gap. Only the decoder notices, when the data end before the picture does (libjpeg warns and fills
// the rest). libjpeg also warns of fill bytes before a marker, which many webcams send in complete pictures.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>

#include "core/image/files/stored_picture.h"

namespace ulf {

struct DecodedJpeg {
  cv::Size size;       // from the header; empty if there is no header
  cv::Mat bgr;         // CV_8UC3; empty if `size` is not the expected one; partly wrong if there is damage
  std::string damage;  // describes the damage for messages; empty if there is none
};
// Decodes a picture without regard to colour profiles or Exif data. Does not throw.
DecodedJpeg DecodeWebcamJpeg(std::span<const std::uint8_t> bytes, cv::Size expected);

// Decodes a photograph and converts it to sRGB; Exif's rotation is ignored. What the decoder says of damaged
// data inside becomes a warning. Throws an Error that begins with `name` if the bytes cannot be decoded, or
// hold a panorama or a stereo pair.
StoredPicture ReadJpeg(std::string_view bytes, const std::string& name);

// Does the same, but returns CV_8UC3 alone, empty if the file is truncated or ReadJpeg() would throw. Rows
// and columns are the sensor's, because the intrinsics belong to the sensor.
cv::Mat DecodeJpeg(const std::string& bytes);

// Encodes 8-bit pixels, one channel or B G R (A is dropped); quality 1 to 100. Throws Error for others.
std::string JpegBytes(const cv::Mat& pixels, int quality = 95);

}  // namespace ulf
