// What a user says of the rolling shutter (`--readout-ms`).
#pragma once

#include <optional>

namespace ulf::tracking {

struct ReadoutArgs {
  std::optional<double> readout_s = {};  // none: looked for
  bool compensate_found = false;
};

}  // namespace ulf::tracking
