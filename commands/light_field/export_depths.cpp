#include "commands/light_field/export_depths.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/photograph_depth.h"

namespace ulf::commands {
namespace {

double ShareOf(std::size_t part, std::size_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(whole, 1));
}

// nerfstudio's parsers take the unit from their command line, and that of COLMAP's folders the folder, too.
std::string AdviceFor(ExportForm form, double unit) {
  constexpr double kOfNerfstudio = 1e-3;
  if (form == ExportForm::kInstantNgp) return {};
  const bool is_colmap = form != ExportForm::kNerfstudio;
  const std::string options =
      std::string(is_colmap ? " --colmap-path sparse/0 --depths-path depths" : "") +
      (unit == kOfNerfstudio ? "" : fmt::format(" --depth-unit-scale-factor {:g}", unit));
  return options.empty() ? ""
                         : fmt::format("nerfstudio reads the depth maps with: {}{}",
                                       is_colmap ? "colmap" : "nerfstudio-data", options);
}

}  // namespace

ExportedDepths DepthsOf(const LightField& light_field, ExportForm form) {
  const auto geometry = std::make_shared<render::PhotographDepths>(light_field);
  ExportedDepths depths;
  depths.source = {.of = [geometry](const View& view,
                                    const CameraModel& exported) { return geometry->Of(view, exported); },
                   .png_unit = render::UnitForSixteenBits(*geometry, light_field)};
  depths.is_metric = light_field.units == "metres";
  if (const auto state = render::GeometryStateOf(light_field); state && state->mesh_fits == false)
    depths.doubt =
        fmt::format("the mesh was made of other views or poses, so depths may be off; make it anew with: {}",
                    render::ProxyCommand(light_field.root));
  depths.advice = AdviceFor(form, depths.source->png_unit);
  return depths;
}

std::string DepthsText(const ExportedDepths& depths, const DepthSummary& summary) {
  if (!depths.source) return {};
  std::string text = fmt::format(
      "depths: {}, along the optical axis, known in {:.1f} % of the pixels; EXR in {}, PNG in {:g} of {}\n",
      Counted(summary.maps, "map"), 100 * ShareOf(summary.known, summary.pixels),
      depths.is_metric ? "metres" : "the light field's own unit", depths.source->png_unit,
      depths.is_metric ? "a metre" : "that unit");
  if (summary.beyond > 0)
    text +=
        fmt::format("{:.2g} % of the known depths are too large for the PNG, where they are 0 (unknown)\n",
                    100 * ShareOf(summary.beyond, summary.known));
  for (const std::string& sentence : {depths.doubt, depths.advice})
    if (!sentence.empty()) text += sentence + "\n";
  return text;
}

nlohmann::ordered_json DepthsJson(const ExportedDepths& depths, const DepthSummary& summary) {
  nlohmann::ordered_json json{{"maps", summary.maps},
                              {"known_share", ShareOf(summary.known, summary.pixels)},
                              {"beyond_share", ShareOf(summary.beyond, summary.known)},
                              {"png_unit", depths.source->png_unit},
                              {"units", depths.is_metric ? "metres" : "arbitrary"}};
  if (!depths.doubt.empty()) json["doubt"] = depths.doubt;
  return json;
}

}  // namespace ulf::commands
