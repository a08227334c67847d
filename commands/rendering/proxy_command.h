// The mesh and the depth maps of a light field, made and written: what `ulf proxy` does, and the capture of a
// turntable at its end.
#pragma once

#include <string>

namespace ulf::commands {

// A mesh that is there moves to kept/, with its depth maps. Throws as BuildProxy() does.
void WriteMeshProxy(const std::string& dir);

}  // namespace ulf::commands
