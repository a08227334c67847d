// Interprets a stored picture's colours, by an ICC profile (ISO 15076) or by primaries and an exponent, and
// converts them to sRGB, through Little CMS.
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

struct ColorTags {
  std::string icc = {};  // the profile's bytes; it has precedence
  std::optional<Primaries> primaries = {};
  // Light is the stored number to this power (1: linear). None means sRGB's curve, for float pixels 1.
  std::optional<double> exponent = {};
  std::string name = {};  // names primaries and exponent in a note; empty: they are written as numbers
};

// Converts pixels whose encoding differs from what StoredPicture promises, and notes it. If the claim is
// damaged or impossible, or the profile is of another space than the pixels, it warns and leaves the pixels.
void ConvertToSrgb(const ColorTags& claim, StoredPicture& picture);

// Converts four inks (C, M, Y, K), CV_8UC4 or CV_16UC4, to sRGB (B, G, R, same depth). `is_inverted`: full
// scale is no ink. Without a usable profile each ink is assumed to be ideal, with a warning in `picture`.
cv::Mat SrgbOfInks(const cv::Mat& inks, bool is_inverted, const std::string& icc, StoredPicture& picture);

// Converts CIE L*a*b*, CV_8UC3 or CV_16UC3 as TIFF codes it (`is_signed`) or as ICC does, to sRGB (B, G, R,
// same depth). `white_xy` is CIE x and y of its white; none means D50.
cv::Mat SrgbOfLab(const cv::Mat& lab, bool is_signed,
                  const std::optional<std::array<double, 2>>& white_xy = {});

}  // namespace ulf
