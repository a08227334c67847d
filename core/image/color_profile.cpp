#include "core/image/color_profile.h"

#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "core/base/json_fields.h"

namespace ulf {

Image ColorProfile::Applied(const Image& image, double black_level, const cv::Mat& clipped) const {
  cv::Mat light = LinearFloat(image);
  const auto black = static_cast<float>(black_level);
  const cv::Vec3f factors(static_cast<float>(white_balance[2]), static_cast<float>(white_balance[1]),
                          static_cast<float>(white_balance[0]));
  const float least_factor = std::min({factors[0], factors[1], factors[2]});
  cv::Matx33f bgr;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      bgr(2 - row, 2 - column) = static_cast<float>(matrix[static_cast<std::size_t>(3 * row + column)]);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      cv::Vec3f& pixel = light.at<cv::Vec3f>(y, x);
      cv::Vec3f balanced = (pixel - cv::Vec3f::all(black)).mul(factors);
      if (!clipped.empty() && clipped.at<std::uint8_t>(y, x) != 0) {
        // Merged exposures are clipped above 1.
        const float full = std::max({1 - black, pixel[0] - black, pixel[1] - black, pixel[2] - black});
        for (int c = 0; c < 3; ++c) balanced[c] = std::min(balanced[c], least_factor * full);
      }
      pixel = bgr * balanced + cv::Vec3f::all(black);
    }
  return {light, Transfer::kLinear};
}

nlohmann::json ColorProfileToJson(const ColorProfile& profile) {
  nlohmann::json json{{"space", "linear sRGB, D65"},
                      {"white_balance", profile.white_balance},
                      {"matrix", profile.matrix},
                      {"source", profile.source}};
  if (profile.raw_white_balance) json["raw_white_balance"] = *profile.raw_white_balance;
  if (profile.delta_e) json["delta_e"] = *profile.delta_e;
  return json;
}

ColorProfile ColorProfileFromJson(const nlohmann::json& json, const std::string& where) {
  const JsonPlace place{json, where + ", color_profile"};
  ColorProfile profile;
  const auto factors = [&](const char* key) {
    const std::vector<double> numbers = place.Numbers(key, 3);
    if (std::ranges::any_of(numbers, [](double factor) { return !(factor > 0); }))
      throw Error("{}: the factors of '{}' must be positive; calibrate again with {}", place.where, key,
                  Parameter("colour"));
    return std::array{numbers[0], numbers[1], numbers[2]};
  };
  if (const std::string space = place.Text("space", "linear sRGB, D65"); space != "linear sRGB, D65")
    throw Error("{}: the colour space '{}' is not known; only 'linear sRGB, D65' is", place.where, space);
  profile.white_balance = factors("white_balance");
  std::ranges::copy(place.Numbers("matrix", 9), profile.matrix.begin());
  if (place.Has("raw_white_balance")) profile.raw_white_balance = factors("raw_white_balance");
  profile.source = place.Text("source", "");
  if (place.Has("delta_e")) profile.delta_e = place.Number("delta_e");
  return profile;
}

}  // namespace ulf
