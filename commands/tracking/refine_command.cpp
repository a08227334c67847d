// `ulf refine`: the poses of a light field made better, and what that does to its coverage.
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "acquisition/calibration/intrinsics.h"
#include "commands/commands.h"
#include "commands/explain.h"
#include "commands/light_field/coverage_change.h"
#include "commands/light_field/geometry_report.h"
#include "commands/light_field/light_field_report.h"
#include "commands/number_checks.h"
#include "commands/tracking/lens_report.h"
#include "commands/tracking/readout_option.h"
#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/model_choice.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/folder_check.h"
#include "core/light_field/light_field_io.h"
#include "core/light_field/points/point_tracks.h"
#include "core/light_field/unposed_photographs.h"
#include "core/light_field/view_numbers.h"
#include "tracking/refine/locate_photographs.h"
#include "tracking/refine/refine.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_truth.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

struct RefineArgs {
  std::string dir;
  std::string output;
  std::string subject;
  std::string truth;
  tracking::RefineOptions options;
  int threads = 2;
  std::optional<double> readout_s;  // none: the light field's
  bool unposed = false;             // look for the photographs in unposed/, too
  bool explain = false;
  bool json = false;
};

// The photographs in unposed/, as far as somebody asked for them.
struct Unposed {
  struct NotFound {
    std::string photograph, why;
  };
  std::size_t first = 0;  // the index of the first one that was located, behind the recorded views
  std::vector<NotFound> not_found;
  bool looked_for = false;
  std::size_t not_looked_for = 0;
};

struct Cost {
  double seconds = 0;
  double peak_mib = 0;
};

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Says where a lens is from that refining found.
std::string RefinedSource(const tracking::RefineResult& result, int camera) {
  const auto fit = result.lens_fits.find(camera);
  return fit != result.lens_fits.end() && fit->second.free.focal
             ? fmt::format("{} (± {:.2f} px)", acquisition::kLensFoundByRefining, fit->second.focal_sigma_px)
             : acquisition::kLensFoundByRefining;
}

// Records the poses in one step, so that a kill leaves the old or the new ones; then the photographs that were found.
void Write(const LightField& before, const Unposed& unposed, const tracking::RefineResult& result,
           LightFieldWriter& writer) {
  std::map<int, Rigid3> poses;
  std::vector<View> found;
  // Refining knows of noise alone, and not of what the map and the shutter add: no view is surer than the usual one.
  std::vector<double> qualities;
  for (std::size_t v = 0; v < unposed.first; ++v) qualities.push_back(before.views[v].tracking_quality);
  const double usual_quality = Median(std::move(qualities));
  for (std::size_t v = 0; v < before.views.size(); ++v) {
    if (!result.views[v].registered) continue;
    if (v < unposed.first) {
      poses[before.views[v].id] = result.views[v].cam_from_world;
    } else {
      found.push_back(before.views[v]);
      found.back().cam_from_world = result.views[v].cam_from_world;
      found.back().tracking_quality = std::min(result.views[v].quality, usual_quality);
    }
  }
  std::map<int, CorrectedLens> lenses;
  for (std::size_t l = 0; l < before.cameras.size(); ++l) {
    const int camera = static_cast<int>(l);
    if (!(result.lenses[l] == before.cameras[l]))
      lenses[camera] = {result.lenses[l], RefinedSource(result, camera)};
  }
  std::map<std::string, std::uint64_t> reasons = before.reasons;
  if (!reasons.empty()) reasons["recorded"] += found.size();
  writer.UpdatePoses(poses, lenses);
  try {
    writer.AddUnposed(std::move(found));
    writer.SetPoints(tracking::WithViewIds(result.points, before));
    writer.Close(before.capture_s, reasons);
  } catch (const Error& error) {
    throw Error(
        "{}; the refined poses are recorded; 'ulf repair {} --write' makes the files that follow from them",
        error.what(), ShellWord(before.root.string()));
  }
}

// Adds the photographs in unposed/ whose place is found to `light_field`, behind its views, with numbers of their own.
Unposed Locate(const RefineArgs& args, const tracking::RefineOptions& options, LightFieldWriter& writer,
               LightField& light_field) {
  Unposed unposed{.first = light_field.views.size(), .not_found = {}, .looked_for = args.unposed};
  const std::vector<UnposedPhotograph> photographs = UnposedPhotographs(light_field);
  if (!args.unposed) {
    unposed.not_looked_for = photographs.size();
    return unposed;
  }
  for (const UnposedPhotograph& photograph : photographs) {
    if (photograph.problem.empty())
      light_field.views.push_back(photograph.view);
    else
      unposed.not_found.push_back({photograph.view.image_path, photograph.problem});
  }
  if (light_field.views.size() == unposed.first) return unposed;
  tracking::LocateOptions locate{.max_side_px = options.max_side_px, .seed = options.seed};
  const std::vector<tracking::LocatedPhotograph> located = tracking::LocatePhotographs(
      tracking::RefineInputOf(light_field), unposed.first, locate, options.progress);
  std::vector<View> found;
  for (std::size_t i = 0; i < located.size(); ++i) {
    View& view = light_field.views[unposed.first + i];
    if (!located[i].cam_from_world) {
      unposed.not_found.push_back({view.image_path, located[i].why});
      continue;
    }
    view.cam_from_world = *located[i].cam_from_world;
    view.id = writer.ReserveViewId();
    found.push_back(std::move(view));
  }
  light_field.views.resize(unposed.first);
  std::ranges::move(found, std::back_inserter(light_field.views));
  return unposed;
}

// Those that refining does not confirm are not found.
void DropUnconfirmed(const LightField& before, const tracking::RefineResult& result, Unposed& unposed) {
  for (std::size_t v = unposed.first; v < before.views.size(); ++v)
    if (!result.views[v].registered)
      unposed.not_found.push_back({before.views[v].image_path, result.views[v].why});
}

nlohmann::ordered_json ToJson(const LightField& before, const tracking::RefineResult& result,
                              const Unposed& unposed) {
  nlohmann::ordered_json json{{"found", nlohmann::ordered_json::array()},
                              {"not_found", nlohmann::ordered_json::array()}};
  for (std::size_t v = unposed.first; v < before.views.size(); ++v)
    if (result.views[v].registered)
      json["found"].push_back({{"photograph", before.views[v].image_path}, {"view", before.views[v].id}});
  for (const Unposed::NotFound& each : unposed.not_found)
    json["not_found"].push_back({{"photograph", each.photograph}, {"why", each.why}});
  return json;
}

std::string ToText(const std::string& dir, const LightField& before, const tracking::RefineResult& result,
                   const Unposed& unposed) {
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
  for (const Unposed::NotFound& each : unposed.not_found) by_reason[each.why].push_back(each.photograph);
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

nlohmann::ordered_json ToJson(const LightField& before, const tracking::RefineResult& result,
                              const Unposed& unposed, const RefineArgs& args, const Cost& cost) {
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
    json["lenses"].push_back(FitJson(fit, args.options.intrinsics));
    json["lenses"].back()["apart"] = LensApartText(fit, before.cameras[At(camera)],
                                                   before.CalibrationSource(camera), args.options.intrinsics);
  }
  json["calibration"] = nlohmann::ordered_json::array();
  for (const tracking::CalibrationCheck& check : result.checks)
    json["calibration"].push_back(ToJson(std::optional(check)));
  json["seconds"] = cost.seconds;
  json["peak_memory_mib"] = cost.peak_mib;
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
  ModelChoice choice{
      lenses > 1 ? fmt::format("intrinsics of lens {}", lens) : "intrinsics",
      "numbers are freed one after the other; one stays free where the information criterion gains more "
      "than ten and the number moves by more than three of its standard deviations",
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

std::vector<ModelChoice> Explained(const tracking::RefineResult& result) {
  std::vector<ModelChoice> choices;
  for (std::size_t l = 0; l < result.lens_trials.size(); ++l)
    choices.push_back(Explained(result.lens_trials[l], l, result.lens_trials.size()));
  return choices;
}

// Lengths as a person can tell what they are: in millimetres, else as shares of the views' distance from the subject,
// else, where it is nowhere that the photographs show, in the world's units.
std::function<std::string(double)> LengthsOf(const LightField& light_field) {
  if (light_field.units == "metres")
    return [](double metres) { return fmt::format("{:.3f} mm", 1000 * metres); };
  std::vector<double> distances;
  const bool subject_is_wrong = std::ranges::any_of(
      light_field.findings, [](const Finding& each) { return each.check == Name(Check::kSubject); });
  if (light_field.subject && !subject_is_wrong)
    for (const View& view : light_field.views)
      distances.push_back((view.CenterInWorld() - light_field.subject->center_in_world).norm());
  if (distances.empty()) return [](double length) { return fmt::format("{:.5f} units", length); };
  return [distance = Median(std::move(distances))](double length) {
    return fmt::format("{:.3f} % of the distance", 100 * length / distance);
  };
}

void PrintText(const std::string& dir, const LightField& before, const tracking::RefineResult& result,
               const Unposed& unposed, const RefineArgs& args, const Cost& cost) {
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
  fmt::print("{}", ToText(dir, before, result, unposed));
  if (result.groups > 1)
    fmt::print("the views fall into {} groups that share no points: their relative poses are as before\n",
               result.groups);
  for (const auto& [camera, fit] : result.lens_fits) {
    fmt::print("{}\n", LensFitText(fit, before.cameras[At(camera)], args.options.intrinsics));
    const std::string apart = LensApartText(fit, before.cameras[At(camera)], before.CalibrationSource(camera),
                                            args.options.intrinsics);
    if (!apart.empty()) fmt::print("{}\n", apart);
  }
  if (!result.lens_fits.empty()) fmt::print("{}\n", kLensSigmaWords);
  if (args.options.intrinsics && result.lens_fits.empty())
    fmt::print("the intrinsics stay: the images support no others\n");
  for (const tracking::CalibrationCheck& check : result.checks)
    if (check.Wrong() && !args.options.intrinsics)
      fmt::print("{}: --intrinsics adjusts the lens together with the poses\n", check.Text());
  fmt::print("{:.1f} s, {:.0f} MiB at most\n", cost.seconds, cost.peak_mib);
}

int RunRefine(const RefineArgs& args) {
  const auto start = std::chrono::steady_clock::now();
  std::string dir = args.dir;
  const std::vector<TimedPose> truth = args.truth.empty() ? std::vector<TimedPose>{} : ReadTum(args.truth);
  if (args.output.empty() && fs::exists(fs::path(dir) / "transforms.json") &&
      !fs::exists(fs::path(dir) / "journal.jsonl") && !IsJournalMissing(dir))
    throw UsageError("{}: a set by another program, which is never written to; give a new folder with -o",
                     dir);
  if (!args.output.empty() && args.unposed)
    throw UsageError(
        "--unposed records the photographs of {} in it; -o makes a copy of its views alone: leave out one of "
        "the two",
        dir);
  if (!args.output.empty()) {
    ImportOptions import;
    if (!args.subject.empty()) import.subject = ParseSubject(args.subject);
    Import(args.dir, args.output, import);
    dir = args.output;
  }
  cv::setNumThreads(args.threads);
  tracking::RefineResult result;
  LightField recorded;  // as it was
  LightField before;    // and behind its views the photographs that were found
  Unposed unposed;
  std::optional<CoverageChange> coverage;
  std::optional<render::GeometryState> geometry_before, geometry;
  double readout_s = 0;
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    before = writer.Contents();
    Progress progress("refine", args.json);
    try {
      tracking::RefineOptions options = args.options;
      options.all_points = true;
      options.progress = [&](double share, const std::string& stage) {
        progress.Show(args.unposed ? 0.5 * share : share, stage);
      };
      unposed = Locate(args, options, writer, before);
      options.progress = [&](double share, const std::string& stage) {
        progress.Show(args.unposed ? 0.5 * (1 + share) : share, stage);
      };
      tracking::RefineInput input = tracking::RefineInputOf(before);
      for (std::size_t v = unposed.first; v < input.views.size(); ++v) input.views[v].is_recorded = false;
      if (args.readout_s) input.readout_s = *args.readout_s;
      readout_s = input.readout_s;
      result = tracking::Refine(input, options);
      DropUnconfirmed(before, result, unposed);
    } catch (const Error& error) {
      throw Error("{}: {}; the light field is as it was", dir, error.what());
    }
    recorded = writer.Contents();
    geometry_before = render::GeometryStateOf(recorded);
    Write(before, unposed, result, writer);
    coverage = CoverageChangeOf(recorded, writer.Contents());
    geometry = render::GeometryStateOf(writer.Contents());
  }
  // Poses that an earlier check found wrong are judged anew, and those that the adjustment contradicts.
  std::optional<LightField> after;
  std::optional<PoseReport> poses;
  if (result.contradicted >= 0 || std::ranges::any_of(recorded.findings, [](const Finding& each) {
        return each.check == Name(Check::kPoses);
      })) {
    after = ReadLightField(dir);
    poses = CheckedPoses(*after, args.json);
  }
  const Cost cost{std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
                  PeakMemoryMib()};
  std::optional<tracking::LightFieldErrors> errors;
  std::string not_compared;  // why; thrown after the report
  if (!args.truth.empty()) try {
      errors = CompareWithTruth(recorded, result, truth, args.truth);
    } catch (const Error& error) {
      not_compared = error.what();
    }
  if (args.json) {
    nlohmann::ordered_json json = ToJson(before, result, unposed, args, cost);
    if (args.unposed) json["unposed"] = ToJson(before, result, unposed);
    json["readout_ms"] = 1000 * readout_s;
    if (args.explain) AddExplained(json, Explained(result));
    if (coverage) json["covered"] = ToJson(*coverage);
    json["outdated"] = Outdated(geometry_before, geometry);
    if (errors) json["truth"] = ToJson(*errors);
    if (poses) json["poses"] = ToJson(*poses, *after);
    fmt::print("{}\n", JsonText(json, 2));
  } else {
    PrintText(dir, before, result, unposed, args, cost);
    if (readout_s != 0)
      fmt::print(
          "rolling shutter of {:.1f} ms: the last adjustment knows the rows ({} of {} with a recorded "
          "velocity)\n",
          1000 * readout_s,
          std::ranges::count_if(before.views, [](const View& view) { return view.twist.has_value(); }),
          Counted(before.views.size(), "view"));
    if (coverage) fmt::print("{}", ToText(*coverage, SourceOf(before), dir));
    fmt::print("{}", OutdatedText(geometry_before, geometry, "the poses before", recorded));
    if (args.explain) fmt::print("{}", ExplainedText(Explained(result)));
    if (errors) fmt::print("{}", ToText(*errors));
    if (poses) fmt::print("{}", ToText(*poses, *after));
  }
  std::fflush(stdout);
  if (!not_compared.empty()) throw Error("{}; the poses are refined and recorded", not_compared);
  return kOk;
}

}  // namespace

void AddRefineCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<RefineArgs>();
  CLI::App* command = app.add_subcommand("refine", "Better poses for all recorded views together");
  command->add_option("DIR", args->dir, "Light field, or with -o a set with transforms.json")->required();
  command->add_option("-o,--output", args->output, "New folder for the result; DIR stays as it is");
  command->add_option("--subject", args->subject, "With -o: x,y,z,radius in world units");
  command->add_flag("--intrinsics", args->options.intrinsics,
                    "Also refine the lens, as far as the images determine it (default: only report it)");
  command->add_flag(
      "--unposed", args->unposed,
      "Also look for the places of the photographs in unposed/; those that are found become views");
  command
      ->add_option("--features", args->options.features, "Corners per view (default: by the number of views)")
      ->check(CLI::Range(300, 10000));
  command->add_option("--max-side", args->options.max_side_px, "Larger pictures are reduced to it, px")
      ->check(CLI::Range(320, 20000));
  command->add_option("--threads", args->threads, "Processors to use; the result is the same for any number")
      ->check(CLI::Range(1, 256));
  command->add_option("--seed", args->options.seed, "Seed of every random draw");
  AddReadoutOption(*command, args->readout_s);
  command->add_option("--truth", args->truth,
                      "True poses, TUM format: prints the errors as recorded, before and after");
  command->add_flag("--explain", args->explain,
                    "Say why these intrinsics: what was tried, and what it gained");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf refine kitchen\nA kill at any moment leaves the old poses or the new ones. Views that "
      "fit "
      "nowhere keep their poses and are named.");
  command->callback([args, &chosen] { chosen = [args] { return RunRefine(*args); }; });
}

}  // namespace ulf::commands
