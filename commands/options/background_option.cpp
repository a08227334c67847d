#include "commands/options/background_option.h"

#include <cstdio>

#include "core/base/error.h"

namespace ulf::commands {

cv::Vec3d BackgroundFromText(const std::string& text) {
  if (text == "white") return cv::Vec3d::all(1);
  if (text == "black") return cv::Vec3d::all(0);
  int red = 0, green = 0, blue = 0, used = 0;
  const auto is_level = [](int level) { return level >= 0 && level <= 255; };
  if (std::sscanf(text.c_str(), "%d,%d,%d%n", &red, &green, &blue, &used) != 3 ||
      static_cast<std::size_t>(used) != text.size() || !is_level(red) || !is_level(green) || !is_level(blue))
    throw UsageError("--background {}: give white, black, or R,G,B from 0 to 255, such as 128,128,128", text);
  return cv::Vec3d(blue, green, red) / 255.0;
}

}  // namespace ulf::commands
