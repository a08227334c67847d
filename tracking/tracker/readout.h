// Describes a rolling shutter for reports. Readout times run from the first row to the last; if they are
// negative, the last row is read first.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace ulf::tracking {

// A readout that changes by a smaller share of itself counts as unchanged. Guessed.
inline constexpr double kSettledReadoutShare = 0.05;

// The readout that was given, or that the tracker has measured (readout_search.h).
struct Readout {
  double readout_s = 0;
  std::optional<double> sigma_s = {};  // one standard deviation of a measured readout; none for a given one
  bool compensated = true;
  // The readout that the map's images show if they contradict the given one, with one standard deviation.
  struct Contradiction {
    double readout_s = 0, sigma_s = 0;
  };
  std::optional<Contradiction> contradicted = {};
  std::string InWords() const;  // a sentence without a full stop
};

// Returns {readout_ms, sigma_ms, compensated, contradicted_by_ms}; null for a global shutter.
nlohmann::ordered_json ToJson(const std::optional<Readout>& rolling);

}  // namespace ulf::tracking
