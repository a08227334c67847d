#include "render/scene/exposure_scales.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/quantile.h"

namespace ulf::render {
namespace {

// Least number of points that a view must share with views of known exposure, and limit of these views.
// Guessed.
constexpr std::size_t kExposureScaleLeastPoints = 12, kMostViews = 6;
// Refused if half of the ratios differ from their median by more than this, of their logarithm. Guessed.
constexpr double kMostDeviation = 0.3;

// Returns none if the view has no exposure; `has_times`, `has_apertures` say whether any view has them.
std::optional<double> ToldExposure(const View& view, bool has_times, bool has_apertures) {
  if (has_times && !(view.exposure_s > 0)) return std::nullopt;
  if (has_apertures && !view.f_number) return std::nullopt;
  const double aperture = view.f_number ? 1 / (*view.f_number * *view.f_number) : 1.0;
  const double exposure = (has_times ? view.exposure_s : 1) * view.gain * aperture;
  return exposure > 0 ? std::optional(exposure) : std::nullopt;
}

std::optional<LightAtPoints> LightOf(const LightField& light_field, const View& view) {
  try {
    return LightAtPoints(light_field, view);
  } catch (const Error& error) {  // its renderer reports the damage
    return std::nullopt;
  }
}

std::optional<double> ExposureByOthers(const LightField& light_field, const View& view,
                                       const std::map<int, double>& known) {
  std::vector<std::pair<std::size_t, int>> others;  // by the number of shared points
  const std::map<int, SharedPoints> shared = PointsSharedWith(light_field, view.id);
  for (const auto& [id, points] : shared)
    if (known.contains(id)) others.emplace_back(points.size(), id);
  std::ranges::sort(others, std::greater());
  others.resize(std::min(others.size(), kMostViews));
  if (others.empty()) return std::nullopt;
  const auto own = LightOf(light_field, view);
  if (!own) return std::nullopt;
  const auto brightness = [](const std::array<double, 3>& bgr) { return bgr[0] + bgr[1] + bgr[2]; };
  std::vector<double> logs;
  for (const auto& [count, id] : others) {
    const auto other = LightOf(light_field, *std::ranges::find(light_field.views, id, &View::id));
    if (!other) continue;
    for (const auto& [here, there] : shared.at(id)) {
      const auto light_here = own->At(here), light_there = other->At(there);
      if (light_here && light_there)
        logs.push_back(std::log(brightness(*light_here) / brightness(*light_there) * known.at(id)));
    }
  }
  if (logs.size() < kExposureScaleLeastPoints) return std::nullopt;
  const double median = Median(logs);
  for (double& log : logs) log = std::abs(log - median);
  if (Median(std::move(logs)) > kMostDeviation) return std::nullopt;
  return std::exp(median);
}

}  // namespace

bool KnowsExposures(const LightField& light_field) {
  return std::ranges::any_of(light_field.views, [](const View& view) {
    return view.exposure_s > 0 || view.gain != 1 || view.f_number.has_value();
  });
}

ExposureScales ScalesOf(const LightField& light_field) {
  const std::vector<View>& views = light_field.views;
  ExposureScales result;
  result.scales.assign(views.size(), 1.0f);
  const bool has_times = std::ranges::any_of(views, [](const View& view) { return view.exposure_s > 0; });
  const bool has_apertures =
      std::ranges::any_of(views, [](const View& view) { return view.f_number.has_value(); });
  std::map<int, double> known;  // by view id
  std::vector<double> exposures;
  for (const View& view : views)
    if (const auto told = ToldExposure(view, has_times, has_apertures)) {
      known[view.id] = *told;
      exposures.push_back(*told);
    }
  if (known.empty()) return result;
  const double median = Median(std::move(exposures));
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::optional<double> exposure;
    if (const auto told = known.find(views[i].id); told != known.end()) {
      exposure = told->second;
    } else {
      exposure = ExposureByOthers(light_field, views[i], known);
      (exposure ? result.estimated : result.unmatched).push_back(views[i].id);
    }
    if (exposure) result.scales[i] = static_cast<float>(median / *exposure);
  }
  return result;
}

}  // namespace ulf::render
