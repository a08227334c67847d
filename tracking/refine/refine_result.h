// What a refinement did to a scene, in numbers: errors before and after, how far views moved, and how sure they are.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/refine/refine.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

// Pixels of the given images for one pixel of the working resolution.
double GivenByWorking(const CameraModel& given, const CameraModel& working);

// By view, how many points it shows.
std::vector<int> PointsByView(const RefineScene& scene);

// Adds views, counts, errors, moves and certainty to `result`, whose lenses and groups are there.
RefineResult Summarise(const RefineOptions& options, const RefineScene& scene, RefineResult result);

}  // namespace ulf::tracking
