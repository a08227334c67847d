// Refines lens and poses for `ulf evaluate --protocol ... --refine` without using the left-out photographs,
// except for their poses. The given views are refined among themselves; a left-out view's photograph
// determines only its own pose, as it did when the set's poses were made.
#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/light_field/light_field.h"
#include "render/quality/protocol.h"

namespace ulf::commands {

struct RefinedSplit {
  LightField light_field;                            // all views, with the given views' points
  std::string summary;                               // one line for people
  double median_before_px = 0, median_after_px = 0;  // of the given views' points
  int not_registered = 0;                            // given views that kept their poses
  int not_placed = 0;  // left-out views that keep their pose relative to their neighbour
};

// Throws Error if the photographs overlap too little for refining.
RefinedSplit RefineForProtocol(const LightField& all, const render::ProtocolSplit& split, Progress& progress);

}  // namespace ulf::commands
