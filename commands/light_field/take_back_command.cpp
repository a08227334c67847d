// ulf take-back removes views of a light field afterwards, like a key of the operator display during a
// capture.

#include <fmt/ranges.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "commands/reports/check_reports.h"
#include "commands/reports/coverage_change.h"
#include "commands/reports/geometry_report.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"

namespace ulf::commands {
namespace {

struct TakeBackArgs {
  std::string dir;
  std::vector<std::string> views;  // "7", "7-9"
  bool json = false;
};

constexpr int kMostInARange = 1'000'000;

struct ViewRange {
  int first = 0, last = 0;
};

std::optional<int> WholeNumber(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

// Throws UsageError for an invalid range.
ViewRange ToViewRange(const std::string& text) {
  const auto dash = text.find('-', 1);
  const auto first = WholeNumber(std::string_view(text).substr(0, dash));
  const auto last = dash == std::string::npos ? first : WholeNumber(std::string_view(text).substr(dash + 1));
  if (!first || !last)
    throw UsageError("'{}' is not a view: give numbers, as 4, or ranges of them, as 4-7", text);
  if (*first < 1 || *last < 1) throw UsageError("'{}' is not a view: views are numbered from 1", text);
  if (*last < *first) throw UsageError("'{}' ends before it begins; write {}-{}", text, *last, *first);
  if (*last - *first >= kMostInARange) throw UsageError("'{}' are more views than any light field has", text);
  return {*first, *last};
}

std::set<int> ViewsOf(const std::vector<std::string>& texts) {
  std::set<int> views;
  for (const std::string& text : texts) {
    const ViewRange range = ToViewRange(text);
    for (int id = range.first; id <= range.last; ++id) views.insert(id);
  }
  return views;
}

// Checks before anything is written: all must be views, or none is taken back.
void RequireViews(const LightField& light_field, const std::set<int>& asked) {
  std::set<int> there, unknown, taken;
  for (const View& view : light_field.views) there.insert(view.id);
  for (const int id : asked)
    if (!there.contains(id)) (light_field.taken_back.contains(id) ? taken : unknown).insert(id);
  const std::string dir = light_field.root.string();
  if (!unknown.empty())
    throw Error("{}: there {} no {}; there {} {}; nothing was taken back", dir,
                unknown.size() == 1 ? "is" : "are", ViewNumbers(unknown), there.size() == 1 ? "is" : "are",
                there.empty() ? "no views" : ViewNumbers(there));
  if (!taken.empty())
    throw Error("{}: {} {} taken back before, see {}/unposed; nothing was taken back now", dir,
                ViewNumbers(taken), taken.size() == 1 ? "was" : "were", dir);
}

// Throws Error that says whether the views are taken back.
void TakeBack(LightFieldWriter& writer, const std::set<int>& asked) {
  try {
    writer.RemoveViews(asked);
  } catch (const std::exception& error) {
    if (!writer.Contents().taken_back.contains(*asked.begin()))
      throw Error("{}; nothing was taken back", error.what());
    throw Error(
        "{}; the views are taken back, and the next command that changes the light field, such as 'ulf "
        "refine', moves the photographs that are still among the others to {}",
        error.what(), (writer.Contents().root / "unposed").string());
  }
}

int RunTakeBack(const TakeBackArgs& args) {
  const std::set<int> asked = ViewsOf(args.views);
  RequireViews(ReadLightField(args.dir), asked);  // before the writer reads every photograph
  LightFieldWriter writer = LightFieldWriter::Resume(args.dir);
  const LightField before = writer.Contents();
  RequireViews(before, asked);
  const auto geometry_before = render::GeometryStateOf(before);
  TakeBack(writer, asked);
  writer.Close(before.capture_s, before.reasons);
  const LightField& after = writer.Contents();
  const auto coverage = CoverageChangeOf(before, after);
  const auto geometry = render::GeometryStateOf(after);
  if (args.json) {
    nlohmann::ordered_json json{{"taken_back", asked}, {"views", after.views.size()}};
    json["covered"] = coverage ? ToJson(*coverage) : nullptr;
    json["outdated"] = Outdated(geometry_before, geometry);
    fmt::print("{}\n", JsonText(json, 2));
    return kOk;
  }
  fmt::print("{}: taken back, kept in unposed/: {}; {} left\n", args.dir, ViewNumbers(asked),
             Counted(after.views.size(), "view"));
  if (coverage) fmt::print("{}", ToText(*coverage, SourceOf(before), args.dir));
  fmt::print("{}", OutdatedText(geometry_before, geometry, "the views before", after));
  return kOk;
}

}  // namespace

void AddTakeBackCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] =
      NewSubcommand(app, chosen, "take-back",
                    "Takes views out of a light field; their photographs stay in unposed/", RunTakeBack);
  command->add_option("DIR", args->dir, "Light field")->required();
  command
      ->add_option("VIEW", args->views,
                   "Numbers of the views, or ranges of them (4-7), as ulf info --check-poses names them and "
                   "as their photographs are named")
      ->required();
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf take-back vase 4 7-9");
}

}  // namespace ulf::commands
