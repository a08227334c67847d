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

// What became of the photographs without a pose in unposed/ (`ulf refine --unposed`).
struct LocatedUnposed {
  struct NotFound {
    std::string photograph, why;  // its path below the light field's folder
  };
  std::size_t first = 0;            // number of recorded views, behind which the located photographs stand
  std::vector<NotFound> not_found;  // photographs that stay without a pose
  bool looked_for = false;
  std::size_t not_looked_for = 0;  // number of such photographs if nothing was asked for
};

struct RefineCost {
  double seconds = 0;
  double peak_mib = 0;  // largest memory of the process
};

// `before` is the unrefined light field, with the located photographs behind its views; `result` has the same
// views. `takes_intrinsics` says that the fitted lens replaces the given one.
void PrintRefined(const std::string& dir, const LightField& before, const tracking::RefineResult& result,
                  const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost);
nlohmann::ordered_json ToJson(const LightField& before, const tracking::RefineResult& result,
                              const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost);
nlohmann::ordered_json UnposedJson(const LightField& before, const tracking::RefineResult& result,
                                   const LocatedUnposed& unposed);

// Explains for each lens which intrinsics were freed, and what each trial gained.
std::vector<ModelChoice> Explained(const tracking::RefineResult& result);

}  // namespace ulf::commands
