#include "coverage/bound/capture_prediction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/counted.h"
#include "core/geometry/angles.h"

namespace ulf::coverage {

CriterionSetup SetupAt(const CameraModel& camera, int coverage_width_px, const Subject& subject,
                       double distance, double threshold_px) {
  const CriterionView view = CriterionView::From(camera, {}, coverage_width_px);
  return {.focal_px = std::max(view.fx, view.fy),
          .distance = distance,
          .radius = subject.radius,
          .threshold_px = threshold_px};
}

ViewsEstimate ViewsEstimate::Of(const Cap& cap, double disc_radius, double share) {
  const Cap reached{std::min(2 * M_PI, cap.width + 0.5 * disc_radius),
                    std::min(M_PI, cap.height + 0.5 * disc_radius)};
  const double usual =
      std::max(1.0, share * reached.SolidAngle() / (std::sqrt(3.0) * disc_radius * disc_radius));
  const double spread = std::sqrt(usual);
  return {.usual = usual, .fewest = std::max(1.0, 0.9 * usual - 0.5 * spread), .most = 1.2 * usual + spread};
}

std::string InWords(const ViewsEstimate& views) {
  // More than two digits would claim a precision that the estimate does not have.
  const auto rounded = [](double value) {
    const double step = std::pow(10, std::max(0.0, std::floor(std::log10(std::max(1.0, value))) - 1));
    return step * std::round(value / step);
  };
  return fmt::format("about {} ({:.0f} to {:.0f})", Counted(std::lround(rounded(views.usual)), "view"),
                     rounded(views.fewest), rounded(views.most));
}

TimeEstimate TimeEstimate::Of(const ViewsEstimate& views, double disc_radius) {
  const double rows_deg = views.usual * Degrees(disc_radius);
  const double experienced_s = 0.075 * rows_deg + 0.117 * views.usual;
  const double novice_s = 0.022 * rows_deg + 0.39 * views.usual;
  const auto [quick_s, slow_s] = std::minmax(experienced_s, novice_s);
  constexpr double kBeginning_s =
      4;  // until the hand moves: at most 3 s in simulated captures of a few views
  return {
      .usual_s = 0.5 * (quick_s + slow_s), .least_s = 0.8 * quick_s, .most_s = 1.33 * slow_s + kBeginning_s};
}

std::string InWords(const TimeEstimate& time) {
  const auto minutes = [](double seconds) {
    return seconds < 600 ? fmt::format("{:.1f}", seconds / 60) : fmt::format("{:.0f}", seconds / 60);
  };
  return fmt::format("about {} min ({} to {} min)", minutes(time.usual_s), minutes(time.least_s),
                     minutes(time.most_s));
}

std::optional<CapturePrediction> Predict(const CriterionSetup& setup, const std::optional<Cap>& cap,
                                         double share) {
  if (!(setup.distance > setup.radius)) return std::nullopt;
  const auto disc_radius = DiscRadius(setup);
  const auto window = DistanceWindow(setup);
  if (!disc_radius || !window) return std::nullopt;
  CapturePrediction prediction{
      .distance = setup.distance, .disc_radius = *disc_radius, .nearest = {}, .farthest = {}, .views = {}};
  if (window->near) prediction.nearest = *window->near * setup.distance;
  if (window->far) prediction.farthest = *window->far * setup.distance;
  if (cap) prediction.views = ViewsEstimate::Of(*cap, *disc_radius, share);
  return prediction;
}

std::optional<std::string> ThresholdWarning(const CapturePrediction& prediction,
                                            const std::optional<Cap>& cap, FrameSource source) {
  constexpr double kMostViews = 100'000;  // guessed
  const char* way_out = IsTaken(source)
                            ? "ask for a smaller cap, a larger threshold or a smaller subject"
                            : "ask for a smaller cap, a larger threshold, a smaller subject or more distance";
  if (prediction.views && prediction.views->usual > kMostViews)
    return fmt::format("{} for this cap: more than a person can take; {}", InWords(*prediction.views),
                       way_out);
  const double finest = CoverageMap::FinestDiscRadius(cap.value_or(Cap::WholeSphere()));
  if (prediction.disc_radius < finest)
    return fmt::format(
        "one view covers {:.2g}°, less than the coverage map of such a cap can show ({:.2g}°): small gaps "
        "will not be seen; {}",
        Degrees(prediction.disc_radius), Degrees(finest), way_out);
  return std::nullopt;
}

std::string DistancesInWords(const std::optional<double>& nearest_share,
                             const std::optional<double>& farthest_share, FrameSource source) {
  if (!nearest_share && !farthest_share) return "any distance works";
  const char* verb = IsTaken(source) ? "it serves" : "keep";
  constexpr char kOf[] = "of the first distance";
  if (nearest_share && farthest_share)
    return fmt::format("{} {:.2f} to {:.2f} {}", verb, *nearest_share, *farthest_share, kOf);
  return nearest_share ? fmt::format("{} at least {:.2f} {}; farther is fine", verb, *nearest_share, kOf)
                       : fmt::format("{} at most {:.2f} {}; closer is fine", verb, *farthest_share, kOf);
}

std::string InWords(const CapturePrediction& prediction, double threshold_px, bool metric,
                    FrameSource source) {
  const auto share = [&](const std::optional<double>& distance) {
    return distance ? std::optional(*distance / prediction.distance) : std::nullopt;
  };
  std::string stay = DistancesInWords(share(prediction.nearest), share(prediction.farthest), source);
  if (metric && (prediction.nearest || prediction.farthest)) {
    const std::string range =
        !prediction.farthest  ? fmt::format("at least {:.2f}", *prediction.nearest)
        : !prediction.nearest ? fmt::format("at most {:.2f}", *prediction.farthest)
                              : fmt::format("{:.2f} to {:.2f}", *prediction.nearest, *prediction.farthest);
    stay = fmt::format("{} {} m from the subject's centre", IsTaken(source) ? "it serves" : "stay", range);
  }
  const std::string covers =
      fmt::format("one view covers {:.1f}° around it", Degrees(prediction.disc_radius));
  return prediction.views ? fmt::format("{} at {:g} px within the cap, more if you go beyond it; {}; {}",
                                        InWords(*prediction.views), threshold_px, covers, stay)
                          : fmt::format("views at {:g} px: {}; {}", threshold_px, covers, stay);
}

}  // namespace ulf::coverage
