// `ulf refine` improves the poses of a light field, and reports the effect on its coverage.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/intrinsics.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "commands/options/tracking_options.h"
#include "commands/options/use_threads.h"
#include "commands/reports/check_reports.h"
#include "commands/reports/coverage_change.h"
#include "commands/reports/explain.h"
#include "commands/reports/geometry_report.h"
#include "commands/reports/work_reports.h"
#include "commands/tracking/refine_report.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/unposed_photographs.h"
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
  bool no_subject = false;
  std::string truth;
  tracking::RefineOptions options;
  int threads = 2;
  std::optional<double> readout_s;  // none: the light field's
  bool unposed = false;             // also locate the photographs in unposed/
  bool explain = false;
  bool json = false;
};

// Describes the origin of a refined lens.
std::string RefinedSource(const tracking::RefineResult& result, int camera) {
  const auto fit = result.lens_fits.find(camera);
  return fit != result.lens_fits.end() && fit->second.free.focal
             ? fmt::format("{} (± {:.2f} px)", acquisition::kLensFoundByRefining, fit->second.focal_sigma_px)
             : acquisition::kLensFoundByRefining;
}

// Records the poses in one step, so that a kill leaves the old or the new ones; then the located photographs.
void Write(const LightField& before, const LocatedUnposed& unposed, const tracking::RefineResult& result,
           LightFieldWriter& writer) {
  std::map<int, Rigid3> poses;
  std::vector<View> found;
  // Refining estimates noise alone, without errors of the map and the shutter: no quality exceeds the usual
  // one.
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

// Adds the located photographs in unposed/ to `light_field`, behind its views, with their own ids.
LocatedUnposed Locate(const RefineArgs& args, const tracking::RefineOptions& options,
                      LightFieldWriter& writer, LightField& light_field) {
  LocatedUnposed unposed{.first = light_field.views.size(), .not_found = {}, .looked_for = args.unposed};
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

// Photographs that refining does not confirm count as not found.
void DropUnconfirmed(const LightField& before, const tracking::RefineResult& result,
                     LocatedUnposed& unposed) {
  for (std::size_t v = unposed.first; v < before.views.size(); ++v)
    if (!result.views[v].registered)
      unposed.not_found.push_back({before.views[v].image_path, result.views[v].why});
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
    import.without_subject = args.no_subject;
    Import(args.dir, args.output, import);
    dir = args.output;
  }
  UseThreads(args.threads);
  tracking::RefineResult result;
  LightField recorded;  // unrefined
  LightField before;    // with the located photographs behind its views
  LocatedUnposed unposed;
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
  // Judges poses again that an earlier check found wrong, and those that the adjustment contradicts.
  std::optional<LightField> after;
  std::optional<PoseReport> poses;
  if (result.contradicted >= 0 || std::ranges::any_of(recorded.findings, [](const Finding& each) {
        return each.check == Name(Check::kPoses);
      })) {
    after = ReadLightField(dir);
    poses = CheckedPoses(*after, args.json);
  }
  const RefineCost cost{SecondsSince(start), PeakMemoryMib()};
  std::optional<tracking::LightFieldErrors> errors;
  std::string not_compared;  // the reason; thrown after the report
  if (!args.truth.empty()) try {
      errors = CompareWithTruth(recorded, result, truth, args.truth);
    } catch (const Error& error) {
      not_compared = error.what();
    }
  if (args.json) {
    nlohmann::ordered_json json = ToJson(before, result, unposed, args.options.intrinsics, cost);
    if (args.unposed) json["unposed"] = UnposedJson(before, result, unposed);
    json["readout_ms"] = 1000 * readout_s;
    if (args.explain) AddExplained(json, Explained(result));
    if (coverage) json["covered"] = ToJson(*coverage);
    json["outdated"] = Outdated(geometry_before, geometry);
    if (errors) json["truth"] = ToJson(*errors);
    if (poses) json["poses"] = ToJson(*poses, *after);
    fmt::print("{}\n", JsonText(json, 2));
  } else {
    PrintRefined(dir, before, result, unposed, args.options.intrinsics, cost);
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
  const auto [command, args] =
      NewSubcommand(app, chosen, "refine", "Better poses for all recorded views together", RunRefine);
  command->add_option("DIR", args->dir, "Light field, or with -o a set with transforms.json")->required();
  command->add_option("-o,--output", args->output, "New folder for the result; DIR stays as it is");
  command->add_option("--subject", args->subject, "With -o: x,y,z,radius in world units");
  command->add_flag("--no-subject", args->no_subject, "With -o: the cameras look outwards, at no subject");
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
      "fit nowhere keep their poses and are named.");
}

}  // namespace ulf::commands
