// Depth maps for `ulf export FORM --depth`, and what is said of them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/light_field.h"

namespace ulf::commands {

struct ExportedDepths {
  std::optional<DepthSource> source;  // none: not asked for
  bool is_metric = false;
  std::string doubt;   // on the geometry that they come from; empty if it fits
  std::string advice;  // by which a program reads them
};

// Throws Error if the light field has no mesh. `light_field` must outlive the result.
ExportedDepths DepthsOf(const LightField& light_field, ExportForm form);

// Returns lines for people, empty without depth maps, and the same for programs.
std::string DepthsText(const ExportedDepths& depths, const DepthSummary& summary);
nlohmann::ordered_json DepthsJson(const ExportedDepths& depths, const DepthSummary& summary);

}  // namespace ulf::commands
