// What a colour profile is worth: differences of colours before and after, by lamp and sensor.
#include <cmath>

#include "acquisition/calibration/color_fit.h"
#include "acquisition/simulator/simulated_chart.h"
#include "core/image/clipped.h"
#include "tests/charts/makers.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Shown {
  const char* name;
  double PatchDifference::*value;
  bool is_default;
};
constexpr Shown kShown[] = {{"as recorded", &PatchDifference::as_recorded, false},
                            {"white balance alone", &PatchDifference::balanced, false},
                            {"profile", &PatchDifference::profiled, false},
                            {"profile, patches left out", &PatchDifference::held_out, true}};

ColorFit FitOf(ChartSceneOptions options, unsigned seed) {
  options.seed = seed;
  options.format = SensorFormat::kBayerRg12;
  std::vector<MeasuredChart> charts;
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    const Image image = RenderChart(options, frame);
    if (const auto chart = FindColorChart(image, 0, ClippedPixels(image))) charts.push_back(*chart);
  }
  return FitColorProfile(charts);
}

template <typename Options>
ChartPanel PanelOver(const std::string& title, const ChartAxis& axis, const std::vector<double>& values,
                     const std::vector<unsigned>& seeds, const Options& options_of) {
  ChartPanel panel{title, axis, {"CIEDE2000, mean of the patches", true}, {}, false};
  std::vector<std::vector<ColorFit>> fits;
  for (const double value : values) {
    fits.emplace_back();
    for (const unsigned seed : seeds) fits.back().push_back(FitOf(options_of(value), seed));
  }
  for (const Shown& shown : kShown)
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::vector<double> means;
      for (const ColorFit& fit : fits[i])
        if (fit.ok()) means.push_back(fit.Mean(shown.value));
      panel.points.push_back({shown.name, fmt::format("{:g}", values[i]), Spread::Exactly(values[i]),
                              Spread::Of(means), shown.is_default});
    }
  return panel;
}

}  // namespace

Chart ColourChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "Colours: before and after a profile from a chart of 24 patches";
  chart.about =
      "sim:chart, 12-bit mosaic with noise, three frames, seeds 1 to 5; bars: lowest to highest seed. "
      "Ringed: the chart's "
      "columns left out in turn, the profile found from the others. The simulated sensor is linear, as the "
      "profile is: "
      "what remains is noise, demosaicing and, with uneven light, the lighting.";
  const std::vector<unsigned> seeds = effort.Of(std::vector{1u}, {1u, 2u, 3u, 4u, 5u});
  chart.panels.push_back(PanelOver(
      "by the lamp, filters overlapping by 0.2", {"colour temperature [K]"},
      effort.Of(std::vector{2800.0, 6500.0}, {2400.0, 3000.0, 4000.0, 5000.0, 6500.0, 8000.0, 10000.0}),
      seeds,
      [](double lamp_k) { return ChartSceneOptions{.colors = {.lamp_k = lamp_k, .crosstalk = 0.2}}; }));
  chart.panels.push_back(
      PanelOver("by the sensor, 4000 K", {"share of each filter's neighbours"},
                effort.Of(std::vector{0.0, 0.3}, {0.0, 0.1, 0.2, 0.3, 0.4}), seeds, [](double crosstalk) {
                  return ChartSceneOptions{.colors = {.lamp_k = 4000, .crosstalk = crosstalk}};
                }));
  chart.panels.push_back(PanelOver(
      "by exposure, 4000 K, 0.2: above 1 patches clip", {"white patch, of full scale", true},
      effort.Of(std::vector{0.5, 1.2}, {0.02, 0.05, 0.1, 0.25, 0.5, 0.9, 1.2, 1.6}), seeds, [](double white) {
        return ChartSceneOptions{.colors = {.lamp_k = 4000, .crosstalk = 0.2}, .white = white};
      }));
  chart.panels.push_back(PanelOver(
      "by the lighting's gradient, 4000 K, 0.2", {"from the left to the right edge [%]"},
      effort.Of(std::vector{0.0, 20.0}, {0.0, 5.0, 10.0, 20.0, 40.0}), seeds, [](double percent) {
        return ChartSceneOptions{.colors = {.lamp_k = 4000, .crosstalk = 0.2}, .gradient = 0.01 * percent};
      }));
  return chart;
}

}  // namespace ulf::test
