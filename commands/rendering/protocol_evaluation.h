// Runs `ulf evaluate --protocol`: its options, the evaluation, its table, JSON and pictures.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "commands/options/scene_options.h"
#include "render/fields/field_options.h"

namespace ulf::commands {

struct ProtocolArgs {
  std::string protocol;                    // empty: not requested
  std::string out;                         // folder to write; empty: nothing is written
  int geometry_px = 0, geometry_maps = 0;  // 0: the defaults of ulf proxy
  bool refine = false;
};

void AddProtocolOptions(CLI::App& sub, ProtocolArgs& args);

// `fields` are those to choose from by evidence; empty means all.
int RunProtocol(const ProtocolArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, bool json);

}  // namespace ulf::commands
