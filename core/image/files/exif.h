// Reads and writes the Exif 2.3 data of a photograph through libexif.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ulf {

struct ExifFacts {
  std::optional<double> exposure_s;
  std::optional<double> f_number;
  std::optional<double> iso;
  std::optional<double> focal_mm;    // of the lens itself, mm
  std::optional<double> focal_35mm;  // mm, of a lens with the same field of view on 36 x 24 mm
  bool is_adobe_rgb = false;         // the colours are marked as Adobe RGB (DCF's R03)
  bool is_other_space = false;       // the colours are marked as not sRGB, and no mark says as what
  int orientation = 1;               // Exif's; 1: not rotated
  // When it was taken, as text that sorts by time: "2026:11:29 10:11:12.345", or in RawFacts 20 digits of
  // seconds since 1970; empty if unknown.
  std::string taken = {};
  std::string lens = {};   // model as its maker names it, ASCII; empty if unknown
  std::string maker = {};  // of the camera, as lens
  std::string model = {};
};

// Converts a camera's text to a line of ASCII, ? for other bytes; empty without a letter or digit ("----").
std::string ExifText(std::string_view bytes);

// Reads the Exif data in the bytes of a JPEG, or in a block that begins with "Exif\0\0". Nothing is set if
// there are none or they cannot be read.
ExifFacts ReadExif(const std::string& jpeg);

// Returns a block that begins with "Exif\0\0": that of `jpeg` (as of ReadExif()), or a new one, in which the
// exposure time, f-number, ISO, focal length, lens, maker and model that `facts` has are set. Others stay.
std::string ExifBlock(const ExifFacts& facts, const std::string& jpeg = {});

}  // namespace ulf
