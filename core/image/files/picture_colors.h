// The meaning of a stored picture's colours, by an ICC profile (ISO 15076) or by primaries and an exponent,
// and their conversion to sRGB, through Little CMS.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/image/files/stored_picture.h"

namespace ulf {

// CIE x and y of red, green, blue and white.
using Primaries = std::array<double, 8>;
inline constexpr Primaries kSrgbPrimaries{0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};

struct ColorClaim {
  std::string icc = {};  // the profile's bytes; it comes before the others
  std::optional<Primaries> primaries = {};
  // Light is the number to this power (1: linear). None: sRGB's curve; of float pixels none means 1.
  std::optional<double> exponent = {};
  std::string name = {};  // of primaries and exponent, for a note; empty: they are written as numbers
};

// Replaces pixels that mean something else than StoredPicture promises, and notes it. A profile that is
// damaged, or of another space than the pixels, is a warning, and the pixels stay.
void ConvertToSrgb(const ColorClaim& claim, StoredPicture& picture);

// sRGB (B, G, R, same depth) of four inks, CV_8UC4 or CV_16UC4. `is_inverted`: full scale means no ink.
// Without a profile of inks, each is taken to be ideal, with a warning.
cv::Mat SrgbOfInks(const cv::Mat& inks, bool is_inverted, const std::string& icc, StoredPicture& picture);

// sRGB of CIE L*a*b*, CV_8UC3 or CV_16UC3 as TIFF codes it (`is_signed`) or as ICC does. `white_xy`: x and y
// of its white; none: D50.
cv::Mat SrgbOfLab(const cv::Mat& lab, bool is_signed,
                  const std::optional<std::array<double, 2>>& white_xy = {});

}  // namespace ulf
