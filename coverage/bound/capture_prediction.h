// What to expect of a capture before its first view: the number of views and the range of distances, for this
// subject, camera and threshold.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/criterion.h"

namespace ulf::coverage {

// How many views a capture by hand takes for a cap, when a view is recorded as soon as the recorded ones no
// longer cover it: along a row one each disc radius R, and rows of such views leave no gap, whatever their
// phase, sqrt(3) R apart. They begin so near the rim that they reach over it by a quarter of R (guidance.h).
// So `share` of a cap as wide and high as this one and R / 2 more, at sqrt(3) R^2 each.
//
// A hand wobbles, and the last holes are filled one by one: simulated people, experienced and novices, over
// caps, thresholds and sizes, took between `fewest` and `most` (docs/guidance.md). They went where guidance
// pointed. Who does not records what lies beyond the cap as well: a hand that scans 60 x 40 degrees took 139
// views where 16 x 10 were asked for and 9 to 17 expected. So the words speak of the cap alone.
struct ViewsEstimate {
  double usual = 0, fewest = 0, most = 0;
  static ViewsEstimate Of(const Cap& cap, double disc_radius, double share = 1);
};
std::string InWords(const ViewsEstimate& views);  // "about 140 views (120 to 180)"

struct CapturePrediction {
  double disc_radius = 0;  // what one view covers around it, radians
  // From the subject's centre, world units: what views at `distance` still cover. None: no limit.
  std::optional<double> nearest, farthest;
  std::optional<ViewsEstimate> views;  // none without a cap
};

// A warning, with what to change, when the cap takes more views than anybody records, or when discs are too
// small for the coverage map's grid. None: no warning.
std::optional<std::string> ThresholdWarning(const CapturePrediction& prediction,
                                            const std::optional<Cap>& cap);

// The camera at `distance` from the subject's centre, in pixels of the coverage image.
CriterionSetup SetupAt(const CameraModel& camera, int coverage_width_px, const Subject& subject,
                       double distance, double threshold_px);

// None where a view covers not even itself: a threshold of 2 px or less, or a camera inside the sphere.
// `share`: of the cap, at which the capture ends.
std::optional<CapturePrediction> Predict(const CriterionSetup& setup, const std::optional<Cap>& cap,
                                         double share);

// "about 140 views (120 to 180) at 12 px; stay 0.85 to 1.20 m from the subject's centre": a line for the
// operator.
std::string InWords(const CapturePrediction& prediction, double threshold_px, bool metric);

}  // namespace ulf::coverage
