// Exit codes, the function that runs the chosen subcommand, how options are spelled, and the error that names
// them.
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
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;

// Set by the subcommand that the command line names; returns the exit code.
using ChosenCommand = std::function<int()>;

// A parameter of the libraries as an option: "no_subject" is "--no-subject", "output" is "-o".
inline std::string OptionOf(std::string_view parameter) {
  if (parameter == "output") return "-o";
  std::string option = "--" + std::string(parameter);
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

// The command line asks for something impossible: exit status kWrongUsage. Thrown by commands/ alone;
// libraries throw Refusal, which names a parameter, and the program spells it as the option.
class UsageError : public Refusal {
 public:
  template <typename... Args>
  explicit UsageError(fmt::format_string<Args...> format, Args&&... args)
      : Refusal("", "", fmt::format(format, std::forward<Args>(args)...), "") {}
};

}  // namespace ulf::commands
