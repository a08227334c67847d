#include "commands/rendering/protocol_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "commands/reports/explain.h"
#include "core/base/counted.h"

namespace ulf::commands {
namespace {

render::ErrorShares MeanErrorsOf(const std::vector<TestView>& views) {
  render::ErrorShares mean;
  const double share = 1 / static_cast<double>(views.size());
  for (const TestView& view : views) {
    for (std::size_t kind = 0; kind < mean.of_error.size(); ++kind) {
      mean.of_error[kind] += share * view.errors.of_error[kind];
      mean.of_pixels[kind] += share * view.errors.of_pixels[kind];
    }
    mean.of_worst_hundredth += share * view.errors.of_worst_hundredth;
  }
  return mean;
}

nlohmann::json JsonOf(const render::ErrorShares& shares) {
  nlohmann::json json;
  for (std::size_t kind = 0; kind < shares.of_error.size(); ++kind)
    json[std::string(render::kErrorKindNames[kind])] = {{"of_error", shares.of_error[kind]},
                                                        {"of_pixels", shares.of_pixels[kind]}};
  json["worst_hundredth_of_pixels"] = {{"of_error", shares.of_worst_hundredth}, {"of_pixels", 0.01}};
  return json;
}

std::string TextOf(const render::ErrorShares& shares) {
  std::string text = "\nsquared error";
  for (std::size_t kind = 0; kind < shares.of_error.size(); ++kind)
    text +=
        fmt::format("{} {}: {:.0f} % in {:.0f} % of the pixels", kind == 0 ? "" : ",",
                    render::kErrorKindNames[kind], 100 * shares.of_error[kind], 100 * shares.of_pixels[kind]);
  return text + fmt::format("; {:.0f} % in the worst hundredth\n", 100 * shares.of_worst_hundredth);
}

nlohmann::json JsonOf(const Costs& costs) {
  return {{"wall_s", costs.wall_s}, {"processor_s", costs.processor_s}};
}

nlohmann::json JsonOf(const render::LightFit& light) {
  return {{"found", light.Words()},
          {"points", light.points},
          {"stops", light.stops},
          {"corner_stops", light.corner_stops}};
}

}  // namespace

render::PaperQuality MeanOf(const std::vector<TestView>& views) {
  render::PaperQuality mean;
  for (double render::PaperQuality::*value :
       {&render::PaperQuality::psnr_db, &render::PaperQuality::ssim, &render::PaperQuality::ssim_uniform,
        &render::PaperQuality::ssim_padded}) {
    for (const TestView& view : views) mean.*value += view.papers.*value;
    mean.*value /= static_cast<double>(views.size());
  }
  return mean;
}

nlohmann::json ToJson(const render::PaperQuality& quality) {
  return {{"psnr_db", quality.psnr_db},
          {"ssim", quality.ssim},
          {"ssim_uniform", quality.ssim_uniform},
          {"ssim_padded", quality.ssim_padded}};
}

nlohmann::json ToJson(const ProtocolResult& result) {
  nlohmann::json json{{"light_field", result.light_field},
                      {"protocol", result.split.name},
                      {"given", result.split.given.size()},
                      {"test", result.split.test.size()},
                      {"width_px", result.width},
                      {"height_px", result.height},
                      {"renderer", result.renderer},
                      {"field", result.field},
                      {"proxy", result.proxy},
                      {"chosen_by", result.why},
                      {"refined", result.refined},
                      {"refining", JsonOf(result.refining)},
                      {"light", result.light ? JsonOf(*result.light) : nullptr},
                      {"geometry", JsonOf(result.geometry)},
                      {"depth_maps", result.depth_maps},
                      {"choice", JsonOf(result.choice)},
                      {"ms_per_picture", result.ms_per_picture},
                      {"lpips", nullptr},
                      {"mean", ToJson(MeanOf(result.views))},
                      {"errors", JsonOf(MeanErrorsOf(result.views))},
                      {"views", nlohmann::json::array()}};
  AddExplained(json, result.explained);
  for (const TestView& view : result.views) {
    nlohmann::json each = ToJson(view.papers);
    each["name"] = view.name;
    each["masked_px"] = view.masked_px;
    each["filled_px"] = view.score.filled_px;
    each["empty_px"] = view.score.empty_px;
    each["ms"] = view.score.ms;
    each["psnr_disc_db"] = view.score.disc.psnr_db;
    each["ssim_disc"] = view.score.disc.ssim;
    json["views"].push_back(each);
  }
  return json;
}

std::string ToText(const ProtocolResult& result) {
  std::string text = fmt::format("{}, protocol {}: {} left out of {}, {}x{}, {}\n", result.light_field,
                                 result.split.name, Counted(result.split.test.size(), "photograph"),
                                 result.split.test.size() + result.split.given.size(), result.width,
                                 result.height, result.renderer);
  if (!result.refined.empty()) text += result.refined + "\n";
  text += fmt::format("{}, proxy {}; {}\n", result.field, result.proxy, result.why);
  if (result.light) text += result.light->Words() + "\n";
  text += "\n";
  std::size_t widest = 4;
  for (const TestView& view : result.views) widest = std::max(widest, view.name.size());
  const auto row = [&](const std::string& name, const render::PaperQuality& quality) {
    text += fmt::format("{:<{}}  {:7.2f}  {:6.4f}  {:12.4f}  {:11.4f}\n", name, widest, quality.psnr_db,
                        quality.ssim, quality.ssim_uniform, quality.ssim_padded);
  };
  text += fmt::format("{:<{}}  {:>7}  {:>6}  {:>12}  {:>11}\n", "", widest, "PSNR", "SSIM", "SSIM uniform",
                      "SSIM padded");
  long masked_px = 0;
  for (const TestView& view : result.views) {
    row(view.name, view.papers);
    masked_px += view.masked_px;
  }
  row("mean", MeanOf(result.views));
  text += TextOf(MeanErrorsOf(result.views));
  text += fmt::format(
      "\ngeometry {:.1f} s ({:.1f} s of processor), choices {:.1f} s ({:.1f}), {:.0f} ms a picture\n",
      result.geometry.wall_s, result.geometry.processor_s, result.choice.wall_s, result.choice.processor_s,
      result.ms_per_picture);
  if (masked_px > 0)
    text += fmt::format(
        "{} pixels of these photographs are masked, or lie beyond their edge after undistortion: they do not "
        "count\n",
        masked_px);
  return text;
}

}  // namespace ulf::commands
