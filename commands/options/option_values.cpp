#include "commands/options/option_values.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "commands/options/command_line.h"

namespace ulf::commands {
namespace {

CLI::Validator NumberCheck(bool zero_too) {
  return CLI::Validator(
      [zero_too](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
                          (value > 0 || (zero_too && value == 0));
        return good ? std::string()
                    : "'" + text + "' is not a number " + (zero_too ? "of 0 or more" : "above 0");
      },
      "");
}
}  // namespace

CLI::Validator Positive() { return NumberCheck(false); }
CLI::Validator NonNegative() { return NumberCheck(true); }

CLI::Option* OfferValues(CLI::Option* option, const std::string& values) {
  return option->type_name("TEXT:{" + values + "}");
}

std::string KeyLines(std::span<const render::KeyHelp> keys) {
  constexpr int kColumn = 26;
  std::string lines;
  for (const render::KeyHelp& help : keys)
    lines += fmt::format("\n  {:<{}}{}", help.keys, kColumn, help.what);
  return lines;
}

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
