// Converts a light field's recorded views to the input of refining and triangulating, and the points back.
#pragma once

#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/refine/refine.h"

namespace ulf::tracking {

// Reads photographs from `light_field`, which must outlive it.
RefineInput RefineInputOf(const LightField& light_field);

// Makes the points' tracks name views by id instead of by index.
std::vector<ScenePoint> WithViewIds(std::vector<ScenePoint> points, const LightField& light_field);

// Without observations in pixels that masks exclude, and without points of which these leave fewer than two.
// Throws Error for a mask that is missing or of another aspect.
std::vector<ScenePoint> WithoutMasked(std::vector<ScenePoint> points, const LightField& light_field);

}  // namespace ulf::tracking
