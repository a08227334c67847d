// Exit codes, and the function that runs the chosen subcommand.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace ulf::commands {

inline constexpr int kOk = 0;
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;

// Set by the subcommand that the command line names; returns the exit code.
using ChosenCommand = std::function<int()>;

}  // namespace ulf::commands
