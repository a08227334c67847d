// `ulf export FORM --light raw|even|exif --format exr|png16|jpeg:95`, and what is said of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "commands/options/command_line.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/light_field.h"

namespace ulf::commands {

struct LightArgs {
  std::string light = "raw";
  std::string format;  // empty: as they are
};
// `has_format`: whether the form has photographs of several kinds.
void AddLightOptions(CLI::App& form, LightArgs& args, bool has_format);

// Sets the options of the export by the arguments. Returns what gives the report's sentences after the
// export. Throws UsageError for values that do not exist. `light_field` must outlive both.
std::function<std::vector<std::string>(const ExportSummary& summary)> SetLight(const LightArgs& args,
                                                                               const LightField& light_field,
                                                                               ExportOptions& options);

}  // namespace ulf::commands
