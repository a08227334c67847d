// The truth by name, as `ulf evaluate --truth` takes it: the simulator can take a picture from anywhere.
#pragma once

#include <memory>
#include <string>

#include "render/quality/truth.h"

namespace ulf::commands {

// "sim:studio?seed=7", as the light field was captured (with --poses known: in the simulator's world), or a
// folder of frame_00000.png (8 or 16 bits, sRGB) or .exr (linear), as `ulf render -o FOLDER` numbers them.
std::unique_ptr<render::TruthSource> TruthFromName(const std::string& name);

}  // namespace ulf::commands
