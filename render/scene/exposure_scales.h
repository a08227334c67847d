// Factors that bring the light of all views to one scale, that of the median exposure: exposure time times
// gain over f-number squared. Where no view has an exposure time, the gain alone counts: a capture estimates
// it from neighbouring photographs (coverage/session/record/exposure).
//
// Of a view that says nothing, while others do, the exposure follows from the scene points that it has in
// common with them: the median over points of how much brighter it shows them. Where too few points are
// shared, that view alone is taken for one of the median exposure; the others are matched all the same.
#pragma once

#include <vector>

#include "core/light_field/folder/light_at_points.h"
#include "core/light_field/light_field.h"

namespace ulf::render {

struct ExposureScales {
  std::vector<float> scales;   // of each view, by index
  std::vector<int> estimated;  // ids of views whose exposure was found by the others
  std::vector<int> unmatched;  // ids of views of which nothing is known
};

// Whether the light field says anything of exposures.
bool KnowsExposures(const LightField& light_field);

// Reads the photographs of views of unknown exposure, and of those that they are compared with; none where
// all exposures are known, or none is.
ExposureScales ScalesOf(const LightField& light_field);

}  // namespace ulf::render
