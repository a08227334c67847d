// What a refinement found out about a lens, for people.
#pragma once

#include <span>
#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::commands {

// `cameras`: the lenses that the light field had. Where the images support another one that shows everything within half a
// pixel of where one of these does, there is nothing to do, and it says so.
std::string LensFitText(const tracking::LensEstimate& fit, std::span<const CameraModel> cameras,
                        bool is_taken_over);

}  // namespace ulf::commands
