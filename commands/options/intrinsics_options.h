// The options for intrinsics, common to all commands that read frames.
#pragma once

#include "acquisition/calibration/intrinsics.h"

namespace CLI {
class App;
}

namespace ulf::commands {
// `args` must outlive the parsing.
void AddIntrinsicsOptions(CLI::App& command, acquisition::IntrinsicsArgs& args);
}  // namespace ulf::commands
