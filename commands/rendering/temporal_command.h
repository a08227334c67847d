// `ulf evaluate --temporal`: its options, the evaluation, its table and JSON.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "commands/options/scene_options.h"
#include "render/quality/temporal_evaluation.h"

namespace ulf::commands {

struct TemporalArgs {
  std::string path;   // empty: no temporal evaluation
  std::string truth;  // empty: the light field's own device, if that is the simulator
  int frames = 0, width = 0;
  std::string strips;  // file to write
};

void AddTemporalOptions(CLI::App& sub, TemporalArgs& args);

// Throws UsageError for a file that cannot be written.
void CheckTemporalOptions(const TemporalArgs& args);

int RunTemporal(const TemporalArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, const std::string& plot, bool json);

}  // namespace ulf::commands
