// The Exif 2.3 data of a photograph's JPEG file, through libexif.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ulf {

struct ExifFacts {
  std::optional<double> exposure_s;
  std::optional<double> f_number;
  std::optional<double> iso;
  std::optional<double> focal_mm;    // of the lens itself
  std::optional<double> focal_35mm;  // of a lens with the same field of view on 36 x 24 mm
  bool is_adobe_rgb = false;         // by the mark R03 of DCF
  bool is_other_space = false;       // it says that its colours are not sRGB, and nothing says which
  int orientation = 1;               // Exif's; 1: not rotated
  std::string taken =
      {};  // "2026:11:29 10:11:12.345", whose order as text is that of the times; empty: not known
  std::string lens = {};  // its model in its maker's words, ASCII; empty: not known
};

// What a camera writes as text, as one line of ASCII; empty where it holds neither letter nor digit ("----").
std::string ExifText(std::string_view bytes);

// The Exif data in the bytes of a JPEG; nothing is set where there are none or they cannot be read.
ExifFacts ReadExif(const std::string& jpeg);

}  // namespace ulf
