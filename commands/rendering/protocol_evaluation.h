// Runs `ulf evaluate --protocol`, which measures renderings as papers do: photographs that a protocol names
// are left out, rendered from the given views alone, and compared (render/quality/protocol.h).
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "commands/options/scene_options.h"
#include "render/fields/field_options.h"

namespace ulf::commands {

struct ProtocolArgs {
  std::string protocol;  // "llff", "nerf-synthetic", "every:N", or a file; empty: not requested
  std::string out;       // new folder for pictures and results; empty: nothing is written
  // Longer side of photographs for geometry, largest number of depth maps; 0: as in `ulf proxy`.
  int geometry_px = 0, geometry_maps = 0;
  bool refine = false;  // refines lens and poses first (refined_split.h)
};

void AddProtocolOptions(CLI::App& sub, ProtocolArgs& args);

// Prints the result as a table, or as one JSON object if `json`, and returns kOk. The best of `fields` is
// chosen by evidence; empty: of all. Throws UsageError for a proxy that the given views cannot make.
int RunProtocol(const ProtocolArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, bool json);

}  // namespace ulf::commands
