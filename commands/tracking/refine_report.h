// Reports the result of `ulf refine` as text and as JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "core/light_field/light_field.h"
#include "tracking/refine/refine.h"

namespace ulf::commands {

// The results for photographs in unposed/, if requested.
struct LocatedUnposed {
  struct NotFound {
    std::string photograph, why;
  };
  std::size_t first = 0;  // index of the first located one, behind the recorded views
  std::vector<NotFound> not_found;
  bool looked_for = false;
  std::size_t not_looked_for = 0;
};

// The cost of a run.
struct RefineCost {
  double seconds = 0;
  double peak_mib = 0;
};

// `before` is the unrefined light field, with the located photographs behind its views. `takes_intrinsics`
// says that the fitted lens replaces the given one.
void PrintRefined(const std::string& dir, const LightField& before, const tracking::RefineResult& result,
                  const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost);
nlohmann::ordered_json ToJson(const LightField& before, const tracking::RefineResult& result,
                              const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost);
nlohmann::ordered_json UnposedJson(const LightField& before, const tracking::RefineResult& result,
                                   const LocatedUnposed& unposed);

// Explains the choice of intrinsics for each lens: the candidates, and their gain.
std::vector<ModelChoice> Explained(const tracking::RefineResult& result);

}  // namespace ulf::commands
