// What a colour profile is worth: differences of colours before and after, by lamp and sensor.
#include <cmath>

#include "acquisition/calibration/color_fit.h"
#include "acquisition/simulator/simulated_chart.h"
#include "core/image/clipped.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
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
void AddOver(const std::string& title, const ChartAxis& axis, const std::vector<double>& values,
             const Options& options_of, const Effort& effort, Table& table) {
  table.Panel(title, axis, Log("CIEDE2000, mean of the patches"), {.compared = false});
  for (const double value : values)
    for (const unsigned seed : effort.Seeds(5))
      if (const ColorFit fit = FitOf(options_of(value), seed); fit.ok())
        for (const Shown& shown : kShown)
          table.Add(title, shown.name, fmt::format("{:g}", value), value, fit.Mean(shown.value),
                    shown.is_default);
}

Chart MeasureColours(const Effort& effort) {
  Table table;
  AddOver(
      "by the lamp, filters overlapping by 0.2", {"colour temperature [K]"},
      effort.Of(std::vector{2800.0, 6500.0}, {2400.0, 3000.0, 4000.0, 5000.0, 6500.0, 8000.0, 10000.0}),
      [](double lamp_k) { return ChartSceneOptions{.colors = {.lamp_k = lamp_k, .crosstalk = 0.2}}; }, effort,
      table);
  AddOver(
      "by the sensor, 4000 K", {"share of each filter's neighbours"},
      effort.Of(std::vector{0.0, 0.3}, {0.0, 0.1, 0.2, 0.3, 0.4}),
      [](double crosstalk) { return ChartSceneOptions{.colors = {.lamp_k = 4000, .crosstalk = crosstalk}}; },
      effort, table);
  AddOver(
      "by exposure, 4000 K, 0.2: above 1 patches clip", {"white patch, of full scale", true},
      effort.Of(std::vector{0.5, 1.2}, {0.02, 0.05, 0.1, 0.25, 0.5, 0.9, 1.2, 1.6}),
      [](double white) {
        return ChartSceneOptions{.colors = {.lamp_k = 4000, .crosstalk = 0.2}, .white = white};
      },
      effort, table);
  AddOver(
      "by the lighting's gradient, 4000 K, 0.2", {"from the left to the right edge [%]"},
      effort.Of(std::vector{0.0, 20.0}, {0.0, 5.0, 10.0, 20.0, 40.0}),
      [](double percent) {
        return ChartSceneOptions{.colors = {.lamp_k = 4000, .crosstalk = 0.2}, .gradient = 0.01 * percent};
      },
      effort, table);
  return {.panels = table.panels()};
}

CHART(colour, MeasureColours, "Colours: before and after a profile from a chart of 24 patches", R"(sim:chart,
  12-bit mosaic with noise, three frames, five seeds; bars: lowest to highest seed. Ringed: the chart's
  columns left out in turn, the profile found from the others. The simulated sensor is linear, as the
  profile is: what remains is noise, demosaicing and, with uneven light, the lighting.)");

}  // namespace
}  // namespace ulf::test
