// What `ulf refine` has come to, as text and as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "core/light_field/light_field.h"
#include "tracking/refine/refine.h"

namespace ulf::commands {

// The photographs in unposed/, as far as somebody asked for them.
struct LocatedUnposed {
  struct NotFound {
    std::string photograph, why;
  };
  std::size_t first = 0;  // the index of the first one that was located, behind the recorded views
  std::vector<NotFound> not_found;
  bool looked_for = false;
  std::size_t not_looked_for = 0;
};

// What a run took.
struct RefineCost {
  double seconds = 0;
  double peak_mib = 0;
};

// `before`: the light field as it was, and behind its views the photographs that were located.
// `takes_intrinsics`: the lens that fits takes the given one's place.
void PrintRefined(const std::string& dir, const LightField& before, const tracking::RefineResult& result,
                  const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost);
nlohmann::ordered_json ToJson(const LightField& before, const tracking::RefineResult& result,
                              const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost);
nlohmann::ordered_json UnposedJson(const LightField& before, const tracking::RefineResult& result,
                                   const LocatedUnposed& unposed);

// Why these intrinsics: what was tried, and what it gained; for each lens.
std::vector<ModelChoice> Explained(const tracking::RefineResult& result);

}  // namespace ulf::commands
