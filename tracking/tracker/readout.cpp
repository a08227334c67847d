#include "tracking/tracker/readout.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace ulf::tracking {

std::string Readout::InWords() const {
  const double ms = 1000 * readout_s;
  if (contradicted) {
    const double told_ms = 1000 * contradicted->readout_s, sigma_ms = 1000 * contradicted->sigma_s;
    constexpr double kSigmas = 3, kShortest_ms = 5;  // below: global as far as images tell
    if (std::abs(told_ms) < std::max(kSigmas * sigma_ms, kShortest_ms))
      return fmt::format("images fit a global shutter, not a rolling one of {:g} ms: leave {} out", ms,
                         Parameter("readout_ms"));
    return fmt::format(
        "images fit a rolling shutter of about {0:.0f} ms (+- {1:.1f}), not the {2:g} ms given: leave "
        "{3} out, or give {0:.0f}",
        told_ms, sigma_ms, ms, Parameter("readout_ms"));
  }
  if (!sigma_s) return fmt::format("rolling shutter of {:.1f} ms: compensated", ms);
  const std::string size =
      fmt::format("rolling shutter of about {:.0f} ms (measured, +- {:.1f}): ", ms, 1000 * *sigma_s);
  if (compensated) return size + "compensated from then on";
  return size + fmt::format("poses suffer where the camera moves fast; {} {:.0f} compensates",
                            Parameter("readout_ms"), ms);
}

nlohmann::ordered_json ToJson(const std::optional<Readout>& rolling) {
  if (!rolling) return nullptr;
  return {
      {"readout_ms", 1000 * rolling->readout_s},
      {"sigma_ms", rolling->sigma_s ? nlohmann::ordered_json(1000 * *rolling->sigma_s) : nullptr},
      {"compensated", rolling->compensated},
      {"contradicted_by_ms",
       rolling->contradicted ? nlohmann::ordered_json(1000 * rolling->contradicted->readout_s) : nullptr}};
}

}  // namespace ulf::tracking
