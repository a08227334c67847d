// The option `--readout-ms` of the commands that track.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>
#include <string>

#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

// `report`: whether `report` is among the words.
inline CLI::Validator IsReadout(bool report) {
  return CLI::Validator(
      [report](const std::string& text) {
        double ms = 0;
        const bool good = text == "auto" || (report && text == "report") ||
                          (CLI::detail::lexical_cast(text, ms) && std::abs(ms) <= 1000);
        return good ? std::string()
                    : "'" + text + "' is neither auto" + (report ? ", report" : "") +
                          " nor milliseconds from -1000 to 1000";
      },
      "");
}

inline void AddReadoutOption(CLI::App& command, tracking::ReadoutArgs& args) {
  command
      .add_option_function<std::string>(
          "--readout-ms",
          [&args](const std::string& text) {
            args = {};
            if (text == "report")
              args.compensate_found = false;
            else if (text != "auto")
              args.readout_s = 1e-3 * std::stod(text);
          },
          "Rolling shutter: milliseconds from the first row to the last (below 0: read from the last; 0: "
          "global), auto: compensated when found (default), or report: only reported")
      ->check(IsReadout(true))
      ->type_name("MS|auto|report");
}

// Of recorded views: nothing is measured.
inline void AddReadoutOption(CLI::App& command, std::optional<double>& readout_s) {
  command
      .add_option_function<std::string>(
          "--readout-ms",
          [&readout_s](const std::string& text) {
            readout_s = text == "auto" ? std::nullopt : std::optional(1e-3 * std::stod(text));
          },
          "Rolling shutter: milliseconds from the first row to the last (below 0: read from the last; 0: "
          "global), or auto: what the capture measured or was given (default)")
      ->check(IsReadout(false))
      ->type_name("MS|auto");
}

}  // namespace ulf::commands
