// The true pictures of `ulf evaluate --truth`: from the simulator, which can take a picture from any place,
// or from a folder.
#pragma once

#include <memory>
#include <string>

#include "tests/charts/temporal/truth.h"

namespace ulf::commands {

// `name`: "sim:studio?seed=7", the device of a light field that was captured with --poses known (poses in the
// simulator's world), or a folder for TruthFromFolder(). Throws UsageError for any other name.
std::unique_ptr<render::TruthSource> TruthFromName(const std::string& name);

}  // namespace ulf::commands
