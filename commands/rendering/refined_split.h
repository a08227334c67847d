// `ulf evaluate --protocol ... --refine`: lens and poses made better before they are used, without a look at
// the left-out photographs where it counts. The given views are refined among themselves; a left-out view's
// photograph tells one thing, where it was taken from, as it did when the set's poses were made.
#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/light_field/light_field.h"
#include "render/quality/protocol.h"

namespace ulf::commands {

struct RefinedSplit {
  LightField light_field;                            // all views, the given views' points
  std::string summary;                               // one line for people
  double median_before_px = 0, median_after_px = 0;  // of the given views' points
  int not_registered = 0;                            // given views that kept their poses
  int not_placed = 0;  // left-out views that stand beside their neighbour as they did before
};

// Throws Error where the photographs share too little for refining.
RefinedSplit RefineForProtocol(const LightField& all, const render::ProtocolSplit& split, Progress& progress);

}  // namespace ulf::commands
