// A light field's recorded views as refining and triangulating take them, and their points given back to it.
#pragma once

#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/refine/refine.h"

namespace ulf::tracking {

// Reads photographs from `light_field`, which must outlive it.
RefineInput RefineInputOf(const LightField& light_field);

// Tracks name views by their ids instead of by their index.
std::vector<ScenePoint> WithViewIds(std::vector<ScenePoint> points, const LightField& light_field);

}  // namespace ulf::tracking
