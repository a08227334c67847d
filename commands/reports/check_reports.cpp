#include "commands/reports/check_reports.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/shell_word.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/kept_findings.h"
#include "tracking/refine/refine_input.h"

namespace ulf::commands {

PoseReport CheckedPoses(LightField& light_field, bool silent) {
  const auto start = std::chrono::steady_clock::now();
  PoseReport report;
  {
    Progress progress("check", silent);
    report.check =
        tracking::CheckPoses(tracking::RefineInputOf(light_field),
                             [&](double share, const std::string& stage) { progress.Show(share, stage); });
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  LightField doubted = light_field;
  doubted.views.clear();
  for (const tracking::ContradictedView& each : report.check.contradicted)
    doubted.views.push_back(light_field.views[At(each.view)]);
  report.exchanged = CheckPictures(doubted).others;
  const std::vector<Finding> found = FindingsOf(report.check, light_field.views);
  const std::string why = KeepFindings(light_field.root, Check::kPoses, found);
  const bool was_found = std::ranges::any_of(
      light_field.findings, [](const Finding& each) { return each.check == Name(Check::kPoses); });
  if (!found.empty()) report.not_kept = why;
  if (found.empty() && was_found && !why.empty())
    report.not_withdrawn = why;
  else if (found.empty())
    for (const Finding& each : light_field.findings)
      if (each.check == Name(Check::kPoses)) report.lapsed = each.Words();
  Replace(Check::kPoses, found, light_field.findings);
  return report;
}

namespace {

// Returns the last line of a report, which says what to do about obstructed views.
std::string AdviceOnObstructed(const LightField& light_field) {
  if (!std::filesystem::exists(light_field.root / "journal.jsonl"))
    return "               a view is left out when transforms.json does not name it\n";
  return fmt::format(
      "               'ulf mask {0} --moved' masks what stood before the lens; 'ulf take-back {0} VIEW' "
      "leaves a view out\n",
      ShellWord(light_field.root.string()));
}

}  // namespace

std::string ToText(const PoseReport& report, const LightField& light_field) {
  const tracking::PoseCheck& check = report.check;
  const auto name = [&](int view) { return light_field.views[At(view)].image_path; };
  std::string text =
      check.fits_poorly
          ? fmt::format("poses          {} ({:.1f} s)\n", FitInWords(check), report.seconds)
          : fmt::format(
                "poses          {} fit the pictures to {:.1f} px, {} do not, {} not judged ({:.1f} s)\n",
                check.agree, check.error_px, check.contradicted.size(), check.undecided.size(),
                report.seconds);
  if (!report.lapsed.empty()) text += fmt::format("               no longer: {}\n", report.lapsed);
  if (!report.not_withdrawn.empty())
    text += fmt::format("               other commands go on repeating what was found before: {}\n",
                        report.not_withdrawn);
  if (!report.not_kept.empty())
    text += fmt::format("               other commands will not repeat it: {}\n", report.not_kept);
  if (!check.convention.empty()) return text;
  for (const tracking::ContradictedView& view : check.contradicted) {
    std::string by;
    for (const int neighbour : view.by) by += (by.empty() ? "" : ", ") + name(neighbour);
    text += fmt::format(
        "contradicted   {}: {:.1f} px off; another pose fits, turned by {:.2f} degrees and {:.2f} % of the "
        "distance away (by {})\n",
        name(view.view), view.error_px, view.turned_deg, 100 * view.moved_share, by);
  }
  for (const tracking::UndecidedView& view : check.undecided)
    text += fmt::format("not judged     {}: {}\n", name(view.view), view.why);
  for (const tracking::ObstructedView& view : check.obstructed)
    text += fmt::format(
        "obstructed     {}: {:.0f} % of the picture shows what no neighbour sees there, {:.0f} % agree\n",
        name(view.view), 100 * view.without_share, 100 * view.agreeing_share);
  if (check.contradicted.empty())
    return check.obstructed.empty() ? text : text + AdviceOnObstructed(light_field);
  const std::string dir = ShellWord(light_field.root.string());
  if (!report.exchanged.empty())
    return text + fmt::format(
                      "               the photographs in images/ of {} differ from their masters: 'ulf "
                      "repair {}' shows how they are made again; then check again\n",
                      ViewNumbers(report.exchanged), dir);
  if (!std::filesystem::exists(light_field.root / "journal.jsonl"))
    return text + fmt::format(
                      "               'ulf refine {} -o NEW' finds better poses in a copy; a view is left "
                      "out when transforms.json does not name it\n",
                      dir);
  return text + fmt::format(
                    "               'ulf refine {0}' finds better poses; 'ulf take-back {0} VIEW' leaves a "
                    "view out\n",
                    dir);
}

nlohmann::json ToJson(const PoseReport& report, const LightField& light_field) {
  const tracking::PoseCheck& check = report.check;
  const auto view_json = [&](int view) {
    return nlohmann::json{{"view", light_field.views[At(view)].id},
                          {"image", light_field.views[At(view)].image_path}};
  };
  nlohmann::json json{{"agree", check.agree},
                      {"error_px", check.error_px},
                      {"fits_poorly", check.fits_poorly},
                      {"fit_error_px", check.fit_error_px},
                      {"repetitive", check.is_repetitive},
                      {"repeated_share", check.repeated_share},
                      {"convention", check.convention},
                      {"seconds", report.seconds},
                      {"contradicted", nlohmann::json::array()},
                      {"differ_from_masters", report.exchanged},
                      {"not_judged", nlohmann::json::array()},
                      {"obstructed", nlohmann::json::array()}};
  for (const tracking::ContradictedView& view : check.contradicted) {
    nlohmann::json one = view_json(view.view);
    one["error_px"] = view.error_px;
    one["turned_deg"] = view.turned_deg;
    one["moved_share"] = view.moved_share;
    one["by"] = nlohmann::json::array();
    for (const int neighbour : view.by) one["by"].push_back(view_json(neighbour));
    json["contradicted"].push_back(std::move(one));
  }
  for (const tracking::UndecidedView& view : check.undecided) {
    nlohmann::json one = view_json(view.view);
    one["why"] = view.why;
    json["not_judged"].push_back(std::move(one));
  }
  for (const tracking::ObstructedView& view : check.obstructed) {
    nlohmann::json one = view_json(view.view);
    one["without_share"] = view.without_share;
    one["agreeing_share"] = view.agreeing_share;
    json["obstructed"].push_back(std::move(one));
  }
  return json;
}

namespace {

// Returns the views whose light differs from that of most: without them the finding lapses. Returns none if
// the light fluctuates.
std::map<int, std::string> ViewsOfOtherLight(const LightCheck& check, const LightField& light_field) {
  std::map<int, std::string> views;
  if (!check.fluctuations.empty()) return views;
  for (const LampDrift& drift : check.drifts) {
    std::map<int, std::string> before, after;
    for (const View& view : light_field.views) {
      if (drift.from_first <= view.id && view.id <= drift.from_last) before[view.id] = view.image_path;
      if (drift.to_first <= view.id && view.id <= drift.to_last) after[view.id] = view.image_path;
    }
    views.merge(before.size() < after.size() ? before : after);
  }
  return views;
}

}  // namespace

void KeepLight(const LightCheck& check, LightField& light_field) {
  std::vector<Finding> found;
  if (std::string advice = LampAdvice(check, SourceOf(light_field)); !advice.empty())
    found.push_back({Name(Check::kLight), std::move(advice), ViewsOfOtherLight(check, light_field)});
  if (const std::string why = KeepFindings(light_field.root, Check::kLight, found);
      !why.empty() && !found.empty())
    spdlog::warn("{}: other commands will not repeat what the light did: {}", light_field.root.string(), why);
  Replace(Check::kLight, found, light_field.findings);
}

nlohmann::json DoubtsJson(const LightField& light_field) {
  nlohmann::json doubts = nlohmann::json::array();
  for (const std::string& words : light_field.doubts)
    doubts.push_back({{"kind", Name(Check::kFiles)}, {"views", nlohmann::json::array()}, {"words", words}});
  for (const Finding& each : light_field.findings) {
    nlohmann::json views = nlohmann::json::array();
    for (const auto& [id, image] : each.views) views.push_back({{"view", id}, {"image", image}});
    doubts.push_back({{"kind", each.check}, {"views", std::move(views)}, {"words", each.Words()}});
  }
  return doubts;
}

FrameSource SourceOf(const LightField& light_field) {
  const std::string& uri = light_field.device_uri;
  if (uri.empty() || uri.starts_with("import:") || uri.starts_with("replay:"))
    return FrameSource::kPhotographs;
  return uri.starts_with("sim:") ? FrameSource::kCamera : FrameSource::kSettableCamera;
}

namespace {

std::string AllChangesInWords(const LightCheck& check) {
  std::string words;
  for (const LampDrift& drift : check.drifts)
    words +=
        fmt::format("{}{} (+- {:.1f})", words.empty() ? "" : "; ", drift.Words(), 100 * drift.standard_error);
  for (const LampFluctuation& waver : check.fluctuations)
    words += (words.empty() ? "" : "; ") + waver.Words();
  return words;
}

std::string LargestChangeInWords(const LightCheck& check) {
  const auto size_of = [](const LampDrift& drift) { return std::abs(drift.difference); };
  if (!check.drifts.empty()) return std::ranges::max_element(check.drifts, {}, size_of)->Words();
  if (check.fluctuations.empty()) return {};
  return std::ranges::max_element(check.fluctuations, {}, &LampFluctuation::spread)->Words();
}

// The finding is kept, and must be right before and after there is a mesh.
std::string AdviceFor(const std::string& changes, FrameSource source) {
  return changes +
         ": the lamp, the daylight or the camera's automatics changed, and rendered pictures change with "
         "them; over a mesh ('ulf proxy DIR' makes one) renderings even this out by --light fit, exports by "
         "--light even" +
         (IsTaken(source) ? ""
                          : fmt::format(". The next time let lamps warm up for a quarter of an hour, shut "
                                        "daylight out, and lock exposure and white balance ({})",
                                        WhereToSet(source)));
}

}  // namespace

std::string LampAdvice(const LightCheck& check, FrameSource source) {
  const std::string largest = LargestChangeInWords(check);
  return largest.empty() ? largest : AdviceFor(largest, source);
}

LightCheck CheckLightOf(const LightField& light_field, Progress& progress) {
  return CheckLight(light_field, [&](double share) { progress.Show(share, "photographs"); });
}

std::string ToText(const LightCheck& check, FrameSource source) {
  std::string text = fmt::format(
      "clipped        {:.2f} % of the pixels of {}",
      check.pixels > 0 ? 100.0 * static_cast<double>(check.clipped_px) / static_cast<double>(check.pixels)
                       : 0,
      Counted(check.views, "view"));
  if (check.most_clipped_view != 0)
    text += fmt::format(", {:.1f} % of view {}", 100 * check.most_clipped_share, check.most_clipped_view);
  for (const auto& [id, why] : check.unread) text += fmt::format("\nnot read       {}", why);
  text += "\nlight          ";
  if (!check.not_compared.empty()) return text + "not compared: " + check.not_compared + "\n";
  if (check.drifts.empty() && check.fluctuations.empty())
    return text +
           fmt::format(
               "the same from the first to the last of {} that were compared, beyond the exposures that {}\n",
               Counted(check.compared, "view"),
               check.exposure_is_told ? "the camera told" : "were found where views overlap");
  return text + AdviceFor(AllChangesInWords(check), source) + "\n";
}

nlohmann::json ToJson(const LightCheck& check) {
  nlohmann::json json{{"views", check.views},
                      {"pixels", check.pixels},
                      {"clipped", check.clipped_px},
                      {"unread", nlohmann::json::array()},
                      {"compared", check.compared},
                      {"exposure_is_told", check.exposure_is_told},
                      {"not_compared", check.not_compared},
                      {"drifts", nlohmann::json::array()},
                      {"wavers", nlohmann::json::array()}};
  for (const LampFluctuation& waver : check.fluctuations)
    json["wavers"].push_back({{"words", waver.Words()}, {"log_spread", waver.spread}});
  for (const auto& [id, why] : check.unread) json["unread"].push_back({{"view", id}, {"words", why}});
  if (check.most_clipped_view != 0)
    json["most_clipped"] = {{"view", check.most_clipped_view}, {"share", check.most_clipped_share}};
  for (const LampDrift& drift : check.drifts)
    json["drifts"].push_back({{"words", drift.Words()},
                              {"log_difference", drift.difference},
                              {"standard_error", drift.standard_error},
                              {"from", {drift.from_first, drift.from_last}},
                              {"to", {drift.to_first, drift.to_last}}});
  return json;
}

}  // namespace ulf::commands
