// Reports a lens that was estimated from the images, for people.
#pragma once

#include <string>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::commands {

// Describes the estimate. `given` is the light field's lens, which it replaces if `is_taken_over`. Otherwise
// the text says that `given` is right if image points differ by less than half a pixel.
std::string LensFitText(const tracking::LensEstimate& fit, const CameraModel& given, bool is_taken_over);

// If the fitted focal length differs from the given one by more than three standard deviations, and image
// points by more than half a pixel, says by how much, the given one's origin (`source`; empty: unknown),
// which of the two is kept, and why. Otherwise returns "".
std::string LensApartText(const tracking::LensEstimate& fit, const CameraModel& given,
                          const std::string& source, bool is_taken_over);

// States what the standard deviations of lenses estimated from images leave out, and for a camera that can
// still be calibrated what knows better.
std::string LensSigmaWords(FrameSource source);

}  // namespace ulf::commands
