#include "tracking/sources/sent_line.h"

#include <cmath>
#include <cstdio>
#include <span>

#include "core/base/at.h"

namespace ulf::tracking {

std::optional<SentLine> ReadSentLine(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == std::string::npos || line[first] == '#') return SentComment{};
  int used = 0;
  const auto all_read = [&] { return line.find_first_not_of(" \t\r", At(used)) == std::string::npos; };
  double value = 0;
  if (std::sscanf(line.c_str(), " sync %lf%n", &value, &used) == 1 && all_read() && std::isfinite(value))
    return SentSync{value};
  if (std::sscanf(line.c_str(), " offset %lf%n", &value, &used) == 1 && all_read() && std::isfinite(value))
    return SentOffset{value};
  double v[8];
  if (std::sscanf(line.c_str(), "%lf %lf %lf %lf %lf %lf %lf %lf%n", v, v + 1, v + 2, v + 3, v + 4, v + 5,
                  v + 6, v + 7, &used) != 8 ||
      !all_read() || !std::isfinite(v[0]))
    return std::nullopt;
  const auto pose = PoseFromNumbers(std::span<const double, 7>(v + 1, 7));
  if (!pose) return std::nullopt;
  return SentPose{v[0], *pose};
}

}  // namespace ulf::tracking
