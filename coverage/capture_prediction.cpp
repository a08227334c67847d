#include "coverage/capture_prediction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ulf {

CriterionSetup SetupAt(const CameraModel& camera, int coverage_width_px, const Subject& subject,
                       double distance, double threshold_px) {
  const CriterionView view = CriterionView::From(camera, {}, coverage_width_px);
  return {.focal_px = std::max(view.fx, view.fy),
          .distance = distance,
          .radius = subject.radius,
          .threshold_px = threshold_px};
}

std::optional<CapturePrediction> Predict(const CriterionSetup& setup, const std::optional<Cap>& cap) {
  if (!(setup.distance > setup.radius)) return std::nullopt;
  const auto disc_radius = DiscRadius(setup);
  const auto window = DistanceWindow(setup);
  if (!disc_radius || !window) return std::nullopt;
  CapturePrediction prediction{.disc_radius = *disc_radius, .nearest = {}, .farthest = {}, .views = {}};
  if (window->near) prediction.nearest = *window->near * setup.distance;
  if (window->far) prediction.farthest = *window->far * setup.distance;
  if (cap) prediction.views = ViewsEstimate(cap->SolidAngle(), *disc_radius);
  return prediction;
}

std::string InWords(const CapturePrediction& prediction, double threshold_px, bool metric) {
  const char* unit = metric ? " m" : "";
  std::string keep;
  if (prediction.nearest && prediction.farthest)
    keep = fmt::format("keep {:.2f} to {:.2f}{} from its centre", *prediction.nearest, *prediction.farthest,
                       unit);
  else if (prediction.nearest)
    keep = fmt::format("keep at least {:.2f}{} from its centre", *prediction.nearest, unit);
  else if (prediction.farthest)
    keep = fmt::format("keep at most {:.2f}{} from its centre", *prediction.farthest, unit);
  else
    keep = "any distance will do";
  const std::string covers =
      fmt::format("one covers {:.1f} degrees around it", prediction.disc_radius * 180 / M_PI);
  return prediction.views ? fmt::format("about {:.0f} views at {:g} px, {}; {}", std::ceil(*prediction.views),
                                        threshold_px, covers, keep)
                          : fmt::format("views at {:g} px: {}; {}", threshold_px, covers, keep);
}

}  // namespace ulf
