#include "commands/reports/bracket_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/counted.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/light_field/light_field_io.h"
#include "render/stereo/bracket_merge.h"

namespace ulf::commands {
namespace {

constexpr double kSaidBlurPx = 2;  // guessed

}  // namespace

BracketReport MergeBrackets(const std::filesystem::path& dir) {
  BracketReport report;
  // Before the writer looks at every photograph.
  if (std::ranges::all_of(ReadLightField(dir).views, [](const View& view) { return view.exposures.empty(); }))
    return report;
  LightFieldWriter writer = LightFieldWriter::Resume(dir);
  const LightField light_field = writer.Contents();
  std::vector<View> views;
  for (const View& view : light_field.views)
    if (!view.exposures.empty()) views.push_back(view);
  if (views.empty()) return report;
  const auto proxy = render::ProxyForBrackets(light_field);
  report.geometry = proxy->Name();
  Progress progress("merge");
  std::vector<double> ghosts;
  for (std::size_t i = 0; i < views.size(); ++i) {
    progress.Show(static_cast<double>(i) / static_cast<double>(views.size()));
    const render::MergedView merged = render::MergeExposuresOf(light_field, views[i], *proxy);
    for (const std::string& words : merged.left_out) progress.Say(words);
    report.left_out += merged.left_out.size();
    if (merged.exposures < 2) continue;
    const double share = merged.merged.ghost_share;
    writer.SetMerged(views[i].id, render::MergedExr(views[i], merged), merged.exposures, share);
    ++report.views;
    report.exposures += static_cast<std::size_t>(merged.exposures);
    report.stops = std::max(report.stops, std::log2(merged.longest / merged.shortest));
    report.clipped_most =
        std::max(report.clipped_most, cv::countNonZero(merged.merged.clipped) /
                                          static_cast<double>(merged.merged.clipped.total()));
    if (merged.most_blur_px > report.blur_most_px) report.blur_most_view = views[i].id;
    report.blur_most_px = std::max(report.blur_most_px, merged.most_blur_px);
    if (ghosts.empty() || share > report.ghosts_most) report.ghosts_most_view = views[i].id;
    report.ghosts_most = std::max(report.ghosts_most, share);
    ghosts.push_back(share);
  }
  if (!ghosts.empty()) report.ghosts_median = Median(ghosts);
  writer.Close(light_field.capture_s, light_field.reasons);
  return report;
}

std::string ToText(const BracketReport& report) {
  if (report.views == 0) return "merged         nothing: no view has other exposures\n";
  std::string text = fmt::format(
      "merged         {} of {} over {:.1f} stops, aligned by {}: merged/\n"
      "ghosts         {:.1f} % of a view's pixels (median; most {:.1f} %, view {}), where exposures "
      "that disagree are left out\n",
      Counted(report.views, "view"), Counted(report.exposures, "exposure"), report.stops, report.geometry,
      100 * report.ghosts_median, 100 * report.ghosts_most, report.ghosts_most_view);
  if (report.clipped_most > 0)
    text += fmt::format("clipped        in all exposures: at most {:.2f} % of a view's pixels\n",
                        100 * report.clipped_most);
  if (report.blur_most_px > kSaidBlurPx)
    text += fmt::format(
        "blurred        at most {:.1f} px (view {}): long exposures in a moving hand count less at edges; "
        "hold "
        "the camera still, or begin with a shorter exposure\n",
        report.blur_most_px, report.blur_most_view);
  if (report.left_out > 0)
    text += fmt::format("left out       {}, whose light is not what its time tells\n",
                        Counted(report.left_out, "exposure"));
  return text;
}

nlohmann::json ToJson(const BracketReport& report) {
  return {{"views", report.views},
          {"exposures", report.exposures},
          {"left_out", report.left_out},
          {"stops", report.stops},
          {"geometry", report.geometry},
          {"ghosts_median", report.ghosts_median},
          {"ghosts_most", report.ghosts_most},
          {"ghosts_most_view", report.ghosts_most_view},
          {"clipped_most", report.clipped_most},
          {"blur_most_px", report.blur_most_px},
          {"blur_most_view", report.blur_most_view}};
}

}  // namespace ulf::commands
