// Computes factors that bring the light of all views to one scale, that of the median exposure: exposure time
// times gain over f-number squared. If no view has an exposure time, the gain alone counts: a capture
// estimates it from neighbouring photographs (coverage/session/record/exposure).
//
// If only some views lack an exposure time, it follows from the scene points that they share with the others:
// the median over points of their brightness ratio. A view that shares too few points is assumed to have the
// median exposure; the others are matched all the same.
#pragma once

#include <vector>

#include "core/light_field/folder/light_at_points.h"
#include "core/light_field/light_field.h"

namespace ulf::render {

struct ExposureScales {
  std::vector<float> scales;   // by view index
  std::vector<int> estimated;  // ids of views whose exposure follows from the others
  std::vector<int> unmatched;  // ids of views with unknown exposure
};

// Returns whether the light field records any exposures.
bool KnowsExposures(const LightField& light_field);

// Reads the photographs of views of unknown exposure, and of those that they are compared with; none if all
// exposures are known, or none is.
ExposureScales ScalesOf(const LightField& light_field);

}  // namespace ulf::render
