// Validators for numbers on the command line, with short messages instead of CLI11's range of 300 digits.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace ulf::commands {

inline CLI::Validator NumberCheck(bool zero_too) {
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
inline CLI::Validator Positive() { return NumberCheck(false); }
inline CLI::Validator NonNegative() { return NumberCheck(true); }

}  // namespace ulf::commands
