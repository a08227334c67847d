// A camera's colours: how its linear light becomes linear sRGB (Rec. 709 primaries, white D65).
//
// Recorded photographs are never changed. A light field keeps the profile of its camera, and ReadViewLight()
// and ReadViewImage() apply it, after the flat field.
//
// White balance and matrix are kept apart because a clipped pixel needs it: where the sensor is full, its
// channels are equal, and balanced they would be as coloured as the balance is. There the balanced channels
// are cut at what the least amplified one holds, so that what is full in all channels is white.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/image/image.h"

namespace ulf {

struct ColorProfile {
  std::array<double, 3> white_balance{1, 1, 1};  // factors of R G B, green 1
  // R G B, by rows, of balanced light; rows sum to one: grey stays grey.
  std::array<double, 9> matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};
  // Of raw files that LibRaw develops: the factors of the sensor's red, green and blue by which the chart was
  // developed, and by which photographs must be. None: the profile is of what the camera sends, and not
  // applied to raw files.
  std::optional<std::array<double, 3>> raw_white_balance = {};
  std::string source = {};             // in words: from what it was found
  std::optional<double> delta_e = {};  // mean CIEDE2000 of patches that took no part; none: of a grey card

  // The image as linear sRGB in float, three channels, exposed as it was. `clipped`: of ClippedPixels(), or
  // empty.
  Image Applied(const Image& image, double black_level, const cv::Mat& clipped) const;

  bool operator==(const ColorProfile&) const = default;
};

// In the journal, in calibration files and in recordings. Throws Error that begins with `where`.
nlohmann::json ColorProfileToJson(const ColorProfile& profile);
ColorProfile ColorProfileFromJson(const nlohmann::json& json, const std::string& where);

}  // namespace ulf
