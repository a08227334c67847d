// A photograph's JPEG file: its pixels, and what it says about how it was taken (Exif 2.3, through libexif).
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace ulf {

struct ExifFacts {
  std::optional<double> exposure_s;
  std::optional<double> f_number;
  std::optional<double> iso;
  int orientation = 1;  // 1: as the sensor has it
};

// Colour as the sensor has it: a camera turned on its side must not turn the intrinsics. Empty when the file
// is cut short or no JPEG.
cv::Mat DecodeJpeg(const std::string& bytes);

// Of a JPEG's bytes; empty where there is none or it cannot be read.
ExifFacts ReadExif(const std::string& jpeg);

}  // namespace ulf
