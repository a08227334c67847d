#include "commands/reports/coverage_change.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/shell_word.h"
#include "coverage/measured/threshold_by_errors.h"

namespace ulf::commands {

std::optional<CoverageChange> CoverageChangeOf(const LightField& before, const LightField& after) {
  if (!before.goal || !before.subject) return std::nullopt;
  const coverage::Cap cap = coverage::Cap::FromDegrees(before.goal->cap_deg);
  const bool by_errors =
      before.measured && coverage::CoverByNamed(before.measured->cover) != coverage::CoverBy::kBound;
  const auto covered = [&](const LightField& light_field) {
    if (light_field.views.empty()) return 0.0;
    const coverage::CoverageMap map = coverage::CoverageOf(
        light_field, *before.subject, cap, before.threshold_px.value_or(coverage::kHighThresholdPx));
    return (by_errors ? coverage::CoverageByErrors(*before.measured, map) : map).CoveredShare();
  };
  return CoverageChange{cap, covered(before), covered(after)};
}

std::string ToText(const CoverageChange& change, FrameSource source, const std::string& light_field) {
  // A cell of the map is a hundredth of a per cent at the least: a difference below two decimals is none.
  const auto rounded = [](double share, int decimals) {
    return fmt::format("{:.{}f}", 100 * share, decimals);
  };
  const int decimals = rounded(change.before, 1) == rounded(change.after, 1) ? 2 : 1;
  const std::string before = rounded(change.before, decimals), after = rounded(change.after, decimals);
  const std::string of =
      fmt::format("of {:g} x {:g} degrees", change.cap.Degrees().x(), change.cap.Degrees().y());
  if (before == after) return fmt::format("covered: {} % {}, as before\n", rounded(change.after, 1), of);
  std::string text = fmt::format("covered: {} % {} before, {} % after", before, of, after);
  if (change.after < change.before)
    text +=
        fmt::format(": {} % {}; 'ulf info {}' says where", rounded(change.before - change.after, decimals),
                    IsTaken(source) ? "is open again" : "must be taken again (ulf capture --resume)",
                    ShellWord(light_field));
  return text + "\n";
}

nlohmann::ordered_json ToJson(const CoverageChange& change) {
  return {{"before", change.before}, {"after", change.after}};
}

}  // namespace ulf::commands
