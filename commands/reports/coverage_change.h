// What a change of views or poses does to the covered share of the cap that the capture was asked for.
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
  double before = 0, after = 0;  // shares of it
};

// As ulf info counts it: by the bound, or by measured errors where the capture was covered by them. None
// without a goal or a subject.
std::optional<CoverageChange> CoverageChangeOf(const LightField& before, const LightField& after);

// "covered: 98.13 % of 40 x 30 degrees before, 98.10 % after: ..."; shares with as many decimals as tell them
// apart. `source`: of the views, which only a camera can take again.
std::string ToText(const CoverageChange& change, FrameSource source, const std::string& light_field);

nlohmann::ordered_json ToJson(const CoverageChange& change);

}  // namespace ulf::commands
