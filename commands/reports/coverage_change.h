// Reports how a change of views or poses affects the covered share of the capture's cap.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/coverage_map.h"

namespace ulf::commands {

struct CoverageChange {
  coverage::Cap cap;
  double before = 0, after = 0;  // covered shares of the cap, 0 to 1
};

// Measures coverage by the bound, or by measured errors if the capture used them, with the subject, cap and
// threshold of `before`. Returns none if that has no goal or no subject.
std::optional<CoverageChange> CoverageChangeOf(const LightField& before, const LightField& after);

// Returns one line: "covered: 98.13 % of 40 x 30 degrees before, 98.10 % after: ...". `source` is that of the
// views, which only a camera can take again; `light_field` is the folder.
std::string ToText(const CoverageChange& change, FrameSource source, const std::string& light_field);

nlohmann::ordered_json ToJson(const CoverageChange& change);

}  // namespace ulf::commands
