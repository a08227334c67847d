// What a capture will ask for, before there is a view: for this subject, camera and threshold.
#pragma once

#include <optional>
#include <string>

#include "acquisition/camera_model.h"
#include "acquisition/light_field.h"
#include "coverage/coverage_map.h"
#include "coverage/criterion.h"

namespace ulf {

struct CapturePrediction {
  double disc_radius = 0;  // what one view covers around it, radians
  // From the subject's centre, world units: what views at `distance` still cover. None: no limit.
  std::optional<double> nearest, farthest;
  std::optional<double> views;  // none without a cap
};

// The camera at `distance` from the subject's centre, in pixels of the coverage image.
CriterionSetup SetupAt(const CameraModel& camera, int coverage_width_px, const Subject& subject,
                       double distance, double threshold_px);

// None where a view covers not even itself: a threshold of 2 px or less, or a camera inside the sphere.
std::optional<CapturePrediction> Predict(const CriterionSetup& setup, const std::optional<Cap>& cap);

// "about 180 views at 12 px; keep 0.85 to 1.2 m": a line for the operator.
std::string InWords(const CapturePrediction& prediction, double threshold_px, bool metric);

}  // namespace ulf
