#include "commands/tracking/refine_report.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "commands/reports/check_reports.h"
#include "commands/reports/lens_report.h"
#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/unposed_photographs.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf::commands {
namespace {

nlohmann::ordered_json LensJson(const CameraModel& lens) {
  return {{"fx", lens.fx},
          {"fy", lens.fy},
          {"cx", lens.cx},
          {"cy", lens.cy},
          {"k1", lens.coefficients[0]},
          {"k2", lens.coefficients[1]}};
}

nlohmann::ordered_json FitJson(const tracking::LensEstimate& fit, bool taken) {
  nlohmann::ordered_json json = LensJson(fit.lens);
  if (fit.free.focal) json["focal_sigma_px"] = fit.focal_sigma_px;
  if (fit.free.principal_point) json["principal_point_sigma_px"] = fit.principal_point_sigma_px;
  if (fit.free.k1) json["k1_sigma"] = fit.k1_sigma;
  if (fit.free.k2) json["k2_sigma"] = fit.k2_sigma;
  json["evidence"] = fit.gain;
  json["taken"] = taken;
  return json;
}

std::string FreedNumbers(const tracking::FreeIntrinsics& free) {
  std::string text;
  for (const auto& [is_free, name] :
       {std::pair(free.focal, "focal length"), std::pair(free.k1, "k1"),
        std::pair(free.principal_point, "principal point"), std::pair(free.k2, "k2")})
    if (is_free) text += (text.empty() ? "" : ", ") + std::string(name);
  return text;
}

ModelChoice Explained(const std::vector<tracking::LensTrial>& trials, std::size_t lens, std::size_t lenses) {
  ModelChoice choice{lenses > 1 ? fmt::format("intrinsics of lens {}", lens) : "intrinsics",
                     "numbers are freed one after the other; one stays free where the information criterion "
                     "gains more than ten and the number moves by more than three of its standard deviations",
                     {{"as given", "gain 0", true}}};
  for (const tracking::LensTrial& trial : trials) {
    if (trial.kept)
      for (auto& candidate : choice.candidates) candidate.chosen = false;
    choice.candidates.push_back(
        {FreedNumbers(trial.fit.free) + " free",
         fmt::format("gain {:.1f}, {:.1f} before it; {}", trial.fit.gain, trial.gain_before,
                     !trial.plausible ? "no real lens has that focal length with that distortion"
                     : trial.moved    ? "moved"
                                      : "moved by less than its uncertainty"),
         trial.kept});
  }
  if (trials.empty()) choice.candidates[0].evidence = "not tried: too few views or points to tell";
  return choice;
}

// Formats lengths intelligibly: in millimetres, or as shares of the views' distance from the subject, or, if
// the photographs do not show it, in world units.
std::function<std::string(double)> LengthsOf(const LightField& light_field) {
  if (light_field.units == "metres")
    return [](double metres) { return fmt::format("{:.3f} mm", 1000 * metres); };
  const bool subject_is_wrong = std::ranges::any_of(
      light_field.findings, [](const Finding& each) { return each.check == Name(Check::kSubject); });
  if (!light_field.subject || subject_is_wrong || light_field.views.empty())
    return [](double length) { return fmt::format("{:.5f} units", length); };
  const auto distances = DistancesTo(*light_field.subject, light_field.views, &View::CenterInWorld);
  return [distance = Median(distances)](double length) {
    return fmt::format("{:.3f} % of the distance", 100 * length / distance);
  };
}

std::string UnposedText(const std::string& dir, const LightField& before,
                        const tracking::RefineResult& result, const LocatedUnposed& unposed) {
  std::string text;
  if (unposed.not_looked_for > 0)
    text += fmt::format("{} in unposed/ without a pose: ulf refine {} --unposed looks for their places\n",
                        Counted(unposed.not_looked_for, "photograph"), ShellWord(dir));
  std::set<int> found;
  const std::size_t taken_back = CountTakenBack(before);
  if (unposed.looked_for && before.views.size() == unposed.first && unposed.not_found.empty())
    text += "no photograph in unposed/ to look for" +
            (taken_back > 0 ? fmt::format(": those of {} that {} taken back stay out until they are renamed",
                                          Counted(taken_back, "view"), taken_back == 1 ? "was" : "were")
                            : std::string()) +
            "\n";
  for (std::size_t v = unposed.first; v < before.views.size(); ++v)
    if (result.views[v].registered) found.insert(before.views[v].id);
  if (!found.empty() || !unposed.not_found.empty())
    text += fmt::format("{} of {} in unposed/ found and recorded{}\n", found.size(),
                        Counted(found.size() + unposed.not_found.size(), "photograph"),
                        found.empty() ? "" : ": " + ViewNumbers(found));
  std::map<std::string, std::vector<std::string>> by_reason;
  for (const LocatedUnposed::NotFound& each : unposed.not_found)
    by_reason[each.why].push_back(each.photograph);
  constexpr std::size_t kNamed = 3;
  for (const auto& [why, photographs] : by_reason) {
    const std::size_t named = photographs.size() > kNamed + 1 ? kNamed : photographs.size();
    text += fmt::format(
        "{}{} {} without a pose: {}\n",
        fmt::join(photographs.begin(), photographs.begin() + static_cast<std::ptrdiff_t>(named), ", "),
        named < photographs.size() ? fmt::format(" and {} more", photographs.size() - named) : "",
        photographs.size() == 1 ? "stays" : "stay", why);
  }
  return text;
}

}  // namespace

nlohmann::ordered_json UnposedJson(const LightField& before, const tracking::RefineResult& result,
                                   const LocatedUnposed& unposed) {
  nlohmann::ordered_json json{{"found", nlohmann::ordered_json::array()},
                              {"not_found", nlohmann::ordered_json::array()}};
  for (std::size_t v = unposed.first; v < before.views.size(); ++v)
    if (result.views[v].registered)
      json["found"].push_back({{"photograph", before.views[v].image_path}, {"view", before.views[v].id}});
  for (const LocatedUnposed::NotFound& each : unposed.not_found)
    json["not_found"].push_back({{"photograph", each.photograph}, {"why", each.why}});
  return json;
}

nlohmann::ordered_json ToJson(const LightField& before, const tracking::RefineResult& result,
                              const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost) {
  nlohmann::ordered_json json{{"views", before.views.size()}, {"registered", result.registered}};
  json["dropped"] = nlohmann::ordered_json::array();
  for (std::size_t v = 0; v < unposed.first; ++v)
    if (!result.views[v].registered)
      json["dropped"].push_back({{"view", before.views[v].id},
                                 {"image", before.views[v].image_path},
                                 {"why", result.views[v].why}});
  json["groups"] = result.groups;
  const PointStatistics points = StatisticsOf(result.points);
  json["points"] = points.points;
  json["observations"] = points.observations;
  json["mean_error_px"] = points.mean_error_px;
  json["adjusted"] = {{"points", result.adjusted_points}, {"observations", result.adjusted_observations}};
  json["start_error_px"] = result.start_error_px;
  json["reprojection_before_px"] = {{"rms", result.rms_before_px}, {"median", result.median_before_px}};
  json["reprojection_after_px"] = {{"rms", result.rms_after_px}, {"median", result.median_after_px}};
  json["rms_after_sigmas"] = result.rms_after_sigmas;
  json["settled"] = result.settled;
  if (result.contradicted >= 0) json["contradicted"] = before.views[At(result.contradicted)].id;
  json["moved"] = {{"median", result.moved_median}, {"largest", result.moved_max}, {"units", before.units}};
  if (result.moved_most >= 0) json["moved"]["view"] = before.views[At(result.moved_most)].id;
  json["turned_deg"] = {{"median", result.turned_median_deg}, {"largest", result.turned_max_deg}};
  if (result.center_sigma_max) {
    json["predicted_error"] = {{"median", *result.center_sigma_median},
                               {"largest", *result.center_sigma_max},
                               {"view", before.views[At(result.least_sure)].id}};
  }
  json["lenses"] = nlohmann::ordered_json::array();
  for (const auto& [camera, fit] : result.lens_fits) {
    json["lenses"].push_back(FitJson(fit, takes_intrinsics));
    json["lenses"].back()["apart"] =
        LensApartText(fit, before.cameras[At(camera)], before.CalibrationSource(camera), takes_intrinsics);
  }
  json["calibration"] = nlohmann::ordered_json::array();
  for (const tracking::CalibrationCheck& check : result.checks)
    json["calibration"].push_back(ToJson(std::optional(check)));
  json["seconds"] = cost.seconds;
  json["peak_memory_mib"] = cost.peak_mib;
  return json;
}

std::vector<ModelChoice> Explained(const tracking::RefineResult& result) {
  std::vector<ModelChoice> choices;
  for (std::size_t l = 0; l < result.lens_trials.size(); ++l)
    choices.push_back(Explained(result.lens_trials[l], l, result.lens_trials.size()));
  return choices;
}

void PrintRefined(const std::string& dir, const LightField& before, const tracking::RefineResult& result,
                  const LocatedUnposed& unposed, bool takes_intrinsics, const RefineCost& cost) {
  const PointStatistics points = StatisticsOf(result.points);
  fmt::print("{}: {} of {} registered by {}, seen {}\n", dir, result.registered,
             Counted(before.views.size(), "view"), Counted(result.adjusted_points, "point"),
             Counted(result.adjusted_observations, "time"));
  fmt::print("points: {}, seen {}, {:.3f} px off (mean)\n", points.points,
             Counted(points.observations, "time"), points.mean_error_px);
  fmt::print(
      "reprojection error: {:.3f} px before, {:.3f} px after (root mean square; median {:.3f}, {:.3f})\n",
      result.rms_before_px, result.rms_after_px, result.median_before_px, result.median_after_px);
  const auto length = LengthsOf(before);
  fmt::print(
      "cameras moved by {} (median; largest {}, view {}) and turned by {:.3f} degrees (largest {:.3f})\n",
      length(result.moved_median), length(result.moved_max),
      before.views[At(std::max(0, result.moved_most))].id, result.turned_median_deg, result.turned_max_deg);
  if (result.center_sigma_max) {
    if (std::isfinite(*result.center_sigma_max))
      fmt::print("they are known to {} (one standard deviation, median; largest {}, view {})\n",
                 length(*result.center_sigma_median), length(*result.center_sigma_max),
                 before.views[At(result.least_sure)].id);
    else
      fmt::print(
          "parts of the views share too few points: the images do not determine their relative poses\n");
  }
  if (!result.settled)
    fmt::print("the adjustment has not converged: check the start poses, or refine again\n");
  if (result.contradicted >= 0)
    fmt::print("most observations of view {} contradict its pose\n",
               before.views[At(result.contradicted)].id);
  for (std::size_t v = 0; v < unposed.first; ++v)
    if (!result.views[v].registered)
      fmt::print("view {} ({}) keeps its pose: {}\n", before.views[v].id, before.views[v].image_path,
                 result.views[v].why);
  fmt::print("{}", UnposedText(dir, before, result, unposed));
  if (result.groups > 1)
    fmt::print("the views fall into {} groups that share no points: their relative poses are as before\n",
               result.groups);
  for (const auto& [camera, fit] : result.lens_fits) {
    fmt::print("{}\n", LensFitText(fit, before.cameras[At(camera)], takes_intrinsics));
    const std::string apart =
        LensApartText(fit, before.cameras[At(camera)], before.CalibrationSource(camera), takes_intrinsics);
    if (!apart.empty()) fmt::print("{}\n", apart);
  }
  if (!result.lens_fits.empty()) fmt::print("{}\n", LensSigmaWords(SourceOf(before)));
  if (takes_intrinsics && result.lens_fits.empty())
    fmt::print("the intrinsics stay: the images support no others\n");
  for (const tracking::CalibrationCheck& check : result.checks)
    if (check.Wrong() && !takes_intrinsics)
      fmt::print("{}: --intrinsics adjusts the lens together with the poses\n", check.Text());
  fmt::print("{:.1f} s, {:.0f} MiB at most\n", cost.seconds, cost.peak_mib);
}

}  // namespace ulf::commands
