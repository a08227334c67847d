// `ulf evaluate --temporal`: its options, the run, its table and JSON.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "commands/rendering/scene_options.h"
#include "render/quality/temporal_evaluation.h"

namespace ulf::commands {

struct TemporalArgs {
  std::string path;   // empty: not asked for
  std::string truth;  // empty: the light field's own device, where that is the simulator
  int frames = 0, width = 0;
  std::string strips;  // picture to write
};

void AddTemporalOptions(CLI::App& sub, TemporalArgs& args);

// UsageError for options that need --temporal, and for a truth that is not to be had.
void CheckTemporalOptions(const TemporalArgs& args);

int RunTemporal(const TemporalArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, const std::string& plot, bool json);

}  // namespace ulf::commands
