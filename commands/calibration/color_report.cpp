#include "commands/calibration/color_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/counted.h"

namespace ulf::commands {
namespace {

using acquisition::ColorFit;
using acquisition::PatchDifference;
using Json = nlohmann::ordered_json;

// Patches by number, as their maker counts them.
std::string Numbers(const std::vector<int>& patches) {
  std::string list;
  for (const int patch : patches) list += fmt::format("{}{}", list.empty() ? "" : ", ", patch + 1);
  return list;
}

Json MeanAndMost(const ColorFit& fit, double PatchDifference::*which) {
  return {{"mean", fit.Mean(which)}, {"most", fit.Most(which)}};
}

}  // namespace

std::string BalanceText(const std::array<double, 3>& white_balance) {
  return fmt::format("R {:.4g}, G {:.4g}, B {:.4g}", white_balance[0], white_balance[1], white_balance[2]);
}

std::string ColorFitText(const ColorFit& fit, std::size_t found, std::size_t looked_at) {
  std::string text =
      fmt::format("chart            found in {} of {}\n", found, Counted(looked_at, "picture"));
  if (!fit.ok()) return text + "refused: " + fit.refusal + "\n";
  const auto row = [&](const char* name, double PatchDifference::*which) {
    text += fmt::format("  {:<36}{:6.2f} {:6.2f}\n", name, fit.Mean(which), fit.Most(which));
  };
  text += fmt::format("white balance    {}\n", BalanceText(fit.profile.white_balance));
  const auto& m = fit.profile.matrix;
  for (int i = 0; i < 9; i += 3)
    text +=
        fmt::format("{:<17}{:8.4f} {:8.4f} {:8.4f}\n", i == 0 ? "matrix" : "", m[static_cast<std::size_t>(i)],
                    m[static_cast<std::size_t>(i + 1)], m[static_cast<std::size_t>(i + 2)]);
  text += fmt::format("difference (CIEDE2000) of {}, mean and largest:\n",
                      fmt::format("{} patches", fit.patches.size()));
  row("as recorded", &PatchDifference::as_recorded);
  row("white balance alone", &PatchDifference::balanced);
  row("with the profile", &PatchDifference::profiled);
  row("on patches left out of the profile", &PatchDifference::held_out);
  if (!fit.clipped.empty())
    text +=
        fmt::format("warning          patches {} are clipped and took no part: the next time expose less\n",
                    Numbers(fit.clipped));
  if (!fit.uneven.empty())
    text += fmt::format(
        "warning          patches {} are uneven (a reflection, a shadow) or dark and took no part\n",
        Numbers(fit.uneven));
  constexpr double kPoor = 5;  // ten times what one barely sees. Guessed.
  if (fit.Mean(&PatchDifference::held_out) > kPoor)
    text +=
        "warning          the profile hardly fits: is the light even, of one lamp, the chart clean, and are "
        "the camera's "
        "own corrections (gamma, saturation, automatic balance) off?\n";
  return text;
}

Json ColorFitJson(const ColorFit& fit, std::size_t found, std::size_t looked_at) {
  Json json{{"refusal", fit.refusal}, {"pictures", looked_at}, {"charts_found", found}};
  if (!fit.ok()) return json;
  json["white_balance"] = fit.profile.white_balance;
  json["matrix"] = fit.profile.matrix;
  json["delta_e"] = {{"as_recorded", MeanAndMost(fit, &PatchDifference::as_recorded)},
                     {"balanced", MeanAndMost(fit, &PatchDifference::balanced)},
                     {"profiled", MeanAndMost(fit, &PatchDifference::profiled)},
                     {"held_out", MeanAndMost(fit, &PatchDifference::held_out)}};
  json["patches"] = Json::array();
  for (const PatchDifference& patch : fit.patches)
    json["patches"].push_back({{"patch", patch.patch + 1},
                               {"as_recorded", patch.as_recorded},
                               {"balanced", patch.balanced},
                               {"profiled", patch.profiled},
                               {"held_out", patch.held_out}});
  const auto numbers = [](const std::vector<int>& patches) {
    Json list = Json::array();
    for (const int patch : patches) list.push_back(patch + 1);
    return list;
  };
  json["clipped_patches"] = numbers(fit.clipped);
  json["uneven_patches"] = numbers(fit.uneven);
  return json;
}

std::string GreyCardText(const acquisition::GreyCard& card) {
  if (!card.ok()) return "refused: " + card.refusal + "\n";
  return fmt::format(
      "white balance    {}\ncard             {:.0f} % of full scale, colours even within {:.1f} %\n",
      BalanceText(card.white_balance), 100 * card.light, 100 * card.unevenness);
}

Json GreyCardJson(const acquisition::GreyCard& card) {
  return {{"refusal", card.refusal},
          {"white_balance", card.white_balance},
          {"light", card.light},
          {"unevenness", card.unevenness}};
}

}  // namespace ulf::commands
