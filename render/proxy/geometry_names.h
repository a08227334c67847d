// Where a light field has geometry of its own, and the command that makes it.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/shell_word.h"

namespace ulf::render {

// The mesh, and the folder of the depth maps beside it (depth_map_files.h).
inline constexpr char kMeshProxyFile[] = "proxy.ply";
inline constexpr char kDepthMapsFolder[] = "depth";

// The command that makes mesh and maps, for messages: "ulf proxy vase".
inline std::string ProxyCommand(const std::filesystem::path& light_field) {
  return "ulf proxy " + ShellWord(light_field.string());
}

}  // namespace ulf::render
