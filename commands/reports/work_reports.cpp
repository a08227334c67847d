#include "commands/reports/work_reports.h"

#include <fmt/core.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/geometry/angles.h"

namespace ulf::commands {

constexpr double kSaidBlurPx = 2;  // guessed

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

std::string ToText(const render::BracketReport& report) {
  if (report.views == 0) return "merged         nothing: no view has other exposures\n";
  std::string text = fmt::format(
      "merged         {} of {} over {:.1f} stops, aligned by {}: merged/\n"
      "ghosts         {:.1f} % of a view's pixels (median; most {:.1f} %, view {}), where exposures that "
      "disagree are left out\n",
      Counted(report.views, "view"), Counted(report.exposures, "exposure"), report.stops, report.geometry,
      100 * report.ghosts_median, 100 * report.ghosts_most, report.ghosts_most_view);
  if (report.clipped_most > 0)
    text += fmt::format("clipped        in all exposures: at most {:.2f} % of a view's pixels\n",
                        100 * report.clipped_most);
  if (report.blur_most_px > kSaidBlurPx)
    text += fmt::format(
        "blurred        at most {:.1f} px (view {}): long exposures in a moving hand count less at edges; "
        "hold the camera still, or begin with a shorter exposure\n",
        report.blur_most_px, report.blur_most_view);
  if (report.left_out > 0)
    text += fmt::format("left out       {}, whose light is not what its time tells\n",
                        Counted(report.left_out, "exposure"));
  return text;
}

nlohmann::json ToJson(const render::BracketReport& report) {
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

std::string ToText(const render::TurntableMasks& masks) {
  std::string words = fmt::format("{} masked, {:.0f} % of the pixels turn\n",
                                  Counted(masks.masks.size(), "view"), 100 * masks.turning_share);
  for (const render::Stand& stand : masks.stands) {
    words += fmt::format("  the camera stood for {}, while the table turned by {:.0f}°",
                         Counted(stand.views.size(), "view"), Degrees(stand.turned));
    constexpr double kWobbles = 0.5, kUnsteady = 2.5;  // pixels; guessed
    if (stand.shift_px > kUnsteady)
      words += fmt::format(
          "; it was moved by up to {:.1f} px meanwhile, masks may be off: the next time let it stand still",
          stand.shift_px);
    else if (stand.shift_px > kWobbles)
      words += fmt::format("; it wobbled by up to {:.1f} px, which is evened out", stand.shift_px);
    words += "\n";
  }
  if (masks.views_between > 0)
    words += fmt::format("  {} between, while the camera was moved: masked by the subject's hull alone\n",
                         Counted(masks.views_between, "view"));
  return words;
}

std::string ToText(const render::MovedMasks& masks, const LightField& light_field) {
  std::string words = fmt::format(
      "{} of {} masked where they show something that their neighbours do not; {:.0f} % "
      "of the pixels could be compared\n",
      masks.masks.size(), Counted(light_field.views.size(), "view"), 100 * masks.judged_share);
  for (const auto& [id, share] : masks.shares)
    words += fmt::format("  {}: {:.0f} %\n", light_field.FindView(id)->image_path, 100 * share);
  return words;
}

}  // namespace ulf::commands
