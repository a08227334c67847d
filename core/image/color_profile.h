// A camera's colour profile, which converts its linear light to linear sRGB (Rec. 709 primaries, white D65).
//
// Recorded photographs are never changed. A light field keeps the profile of its camera, and ReadViewLight()
// and ReadViewImage() apply it, after the flat field.
//
// White balance and matrix are kept apart because of clipped pixels: where the sensor is full, its channels
// are equal, and balancing would colour them. There the balanced channels are cut at the full scale of the
// least amplified one, so that a pixel that is full in all channels is white.
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
  // Matrix from balanced R G B, row by row; each row sums to one, so grey stays grey.
  std::array<double, 9> matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};
  // The factors of the sensor's red, green and blue with which LibRaw developed the colour chart's raw file
  // and must develop photographs. None: the profile is for what the camera sends, not for raw files.
  std::optional<std::array<double, 3>> raw_white_balance = {};
  std::string source = {};             // describes what it was estimated from
  std::optional<double> delta_e = {};  // mean CIEDE2000 of patches left out; none for a grey card

  // Returns the image as linear sRGB, CV_32FC3. `black_level`, a share of full scale, stays in it. `clipped`
  // is the result of ClippedPixels(), or empty.
  Image Applied(const Image& image, double black_level, const cv::Mat& clipped) const;

  bool operator==(const ColorProfile&) const = default;
};

// For the journal, calibration files and recordings. Reading throws an Error that begins with `where`.
nlohmann::json ColorProfileToJson(const ColorProfile& profile);
ColorProfile ColorProfileFromJson(const nlohmann::json& json, const std::string& where);

}  // namespace ulf
