// Lenses, and where their numbers are from: a light field has one camera to begin with, and
// another for each lens that was given on purpose since.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/image/color_profile.h"
#include "core/image/flat_field.h"

namespace ulf {

struct NewCamera {
  CameraModel camera;
  std::optional<FlatField> flat_field;
  std::optional<ColorProfile> color_profile;
  std::string calibration_source;
};

// New intrinsics of a camera that a light field has.
struct CorrectedLens {
  CameraModel camera;
  std::string calibration_source;  // empty: from where they were
};

}  // namespace ulf
