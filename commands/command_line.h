// What a subcommand is to main.cpp: a name that, when chosen, leaves behind a function to run.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace ulf::commands {

inline constexpr int kOk = 0;
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;

// Filled by the subcommand that the command line names.
using ChosenCommand = std::function<int()>;

}  // namespace ulf::commands
