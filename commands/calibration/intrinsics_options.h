// The options by which every command that takes frames lets its user say the intrinsics.
#pragma once

#include "acquisition/calibration/intrinsics.h"

namespace CLI {
class App;
}

namespace ulf::commands {
// `args` must outlive the parsing.
void AddIntrinsicsOptions(CLI::App& command, acquisition::IntrinsicsArgs& args);
}  // namespace ulf::commands
