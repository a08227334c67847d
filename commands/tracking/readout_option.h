// The option `--readout-ms` of the commands that track.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

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
      ->check([](const std::string& text) {
        double ms = 0;
        const bool good = text == "auto" || text == "report" ||
                          (CLI::detail::lexical_cast(text, ms) && std::abs(ms) <= 1000);
        return good ? std::string()
                    : "'" + text + "' is neither auto, report nor milliseconds from -1000 to 1000";
      })
      ->type_name("MS|auto|report");
}

}  // namespace ulf::commands
