// Computes factors that bring the light of all views to one scale, that of the median exposure: exposure time
// times gain over f-number squared. If no view has an exposure time, the gain stands for it: a capture
// estimates it from neighbouring photographs (coverage/session/record/exposure).
//
// If only some views lack an exposure time or an f-number, their exposure follows from the scene points that
// they share with the others: the median over points of the brightness ratio. A view whose points are too few
// or disagree is assumed to have the median exposure; the others are matched all the same.
#pragma once

#include <vector>

#include "core/light_field/folder/light_at_points.h"
#include "core/light_field/light_field.h"

namespace ulf::render {

struct ExposureScales {
  std::vector<float> scales;   // by view index: median exposure over the view's
  std::vector<int> estimated;  // ids of views whose exposure follows from the others
  std::vector<int> unmatched;  // ids of views whose exposure remains unknown
};

// Returns whether the light field records an exposure time, a gain or an f-number of any view.
bool KnowsExposures(const LightField& light_field);

// Reads only the photographs of views of unknown exposure and of the views that they are compared with.
ExposureScales ScalesOf(const LightField& light_field);

}  // namespace ulf::render
