// Defines exit codes, the function that runs the chosen subcommand, and the error about a command line.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace ulf::commands {

inline constexpr int kOk = 0;
inline constexpr int kFailed = 1;      // Error: a file, a device or the data
inline constexpr int kWrongUsage = 2;  // UsageError, Refusal: the command line

// Runs the subcommand that the command line names, and returns the exit code. Parsing sets this function.
using ChosenCommand = std::function<int()>;

// Spells a parameter of the libraries as an option: "no_subject" is "--no-subject", "output" is "-o".
inline std::string OptionOf(std::string_view parameter) {
  if (parameter == "output") return "-o";
  std::string option = "--" + std::string(parameter);
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

// Says that the command line is impossible (exit status kWrongUsage). The constructor takes the whole
// message. Only commands/ throws it; libraries throw Refusal, whose parameter is spelled as an option.
class UsageError : public Refusal {
 public:
  template <typename... Args>
  explicit UsageError(fmt::format_string<Args...> format, Args&&... args)
      : Refusal("", "", fmt::format(format, std::forward<Args>(args)...), "") {}
};

}  // namespace ulf::commands
