// Predicts a capture before its first view: the number of views and the range of distances, for a subject,
// camera and threshold.
#pragma once

#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/criterion.h"

namespace ulf::coverage {

// Estimates how many views a capture by hand takes for a `share` of a cap (docs/coverage_bound.md, "Closed
// forms", 5). `disc_radius`: the angle around its direction that a view covers, radians.
//
// A hand wobbles, and the last holes are filled one by one: simulated people, experienced and novices, over
// caps, thresholds and sizes, took between `fewest` and `most` (docs/capture.md#guidance). They went where
// guidance pointed. A person who does not also records views beyond the cap, which no estimate counts: a hand
// that scanned 60 x 40 degrees took 139 views where 16 x 10 were asked for and 9 to 17 expected.
struct ViewsEstimate {
  double usual = 0, fewest = 0, most = 0;
  static ViewsEstimate Of(const Cap& cap, double disc_radius, double share = 1);
};
std::string InWords(const ViewsEstimate& views);  // "about 140 views (120 to 180)"

// Estimates how long a person who goes where guidance points takes for so many views, with a camera of 15
// frames a second or more. The rows are as long as the views' number times the disc's radius; an experienced
// hand takes 0.075 s for each degree of them and 0.117 s for each view, a novice 0.022 and 0.39 s (through
// the medians of docs/measured/capture.md, "With and without guidance": 36 to 123 and 39 to 220 s). `usual_s`
// is the mean of the two; `least_s` is a fifth below the shorter, `most_s` a third above the longer, as the
// seeds scatter there, and 4 s for the beginning. The estimate does not hold for a tethered camera's
// photographs, for which each camera takes its own time.
struct TimeEstimate {
  double usual_s = 0, least_s = 0, most_s = 0;
  static TimeEstimate Of(const ViewsEstimate& views, double disc_radius);
};
std::string InWords(const TimeEstimate& time);  // "about 1.0 min (0.6 to 1.5 min)"

struct CapturePrediction {
  double distance = 0;     // of the first view from the subject's centre, world units
  double disc_radius = 0;  // the angle around its direction that one view covers, radians
  // The nearest and farthest viewpoints that a view at `distance` covers in its own direction, as distances
  // from the subject's centre, world units; none: no limit.
  std::optional<double> nearest, farthest;
  std::optional<ViewsEstimate> views;  // none without a cap
};

// Returns a warning, with what to change, when the cap takes more views than anybody records, or when discs
// are too small for the coverage map's grid; none when there is nothing to warn of. By `source`, here and
// below, the words advise nothing that can no longer be done with pictures that are taken already.
std::optional<std::string> ThresholdWarning(const CapturePrediction& prediction,
                                            const std::optional<Cap>& cap, FrameSource source);

// Returns the camera at `distance` from the subject's centre, in pixels of the coverage image.
CriterionSetup SetupAt(const CameraModel& camera, int coverage_width_px, const Subject& subject,
                       double distance, double threshold_px);

// Predicts the capture; none where a view does not even cover itself, because the threshold is below 2 px or
// the camera is inside the sphere. `share`: the share of the cap at which the capture ends.
std::optional<CapturePrediction> Predict(const CriterionSetup& setup, const std::optional<Cap>& cap,
                                         double share);

// Returns words such as "keep at least 0.68 of the first distance; farther is fine" for the limits of
// CapturePrediction as shares of its `distance`; none: no limit.
std::string DistancesInWords(const std::optional<double>& nearest_share,
                             const std::optional<double>& farthest_share, FrameSource source);

// Returns a line for the operator: "about 140 views (120 to 180) at 12 px within the cap, more if you go
// beyond it; one view covers 2.4° around it; stay 0.85 to 1.20 m from the subject's centre". `metric`: world
// units are metres; else the distances are shares of the first one.
std::string InWords(const CapturePrediction& prediction, double threshold_px, bool metric,
                    FrameSource source);

}  // namespace ulf::coverage
