// Refines lens and poses for `ulf evaluate --protocol ... --refine`. The given views and the lens are refined
// without the left-out photographs, each of which determines only its own view's pose.
#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/light_field/light_field.h"
#include "render/quality/protocol.h"

namespace ulf::commands {

struct RefinedSplit {
  LightField light_field;                            // all views, with the points of the given views alone
  std::string summary;                               // one line for people
  double median_before_px = 0, median_after_px = 0;  // reprojection errors of the given views' points
  int not_registered = 0;                            // number of given views that kept their poses
  int not_placed = 0;  // number of left-out views that kept their pose relative to their nearest given view
};

// `split` holds indices of views of `all`. Throws Error if the photographs overlap too little for refining.
RefinedSplit RefineForProtocol(const LightField& all, const render::ProtocolSplit& split, Progress& progress);

}  // namespace ulf::commands
