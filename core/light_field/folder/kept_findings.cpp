#include "core/light_field/folder/kept_findings.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/journal_stamp.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Limit of views with photograph digests, and of examples of a light field that is wrong as a whole: they are
// opened on every reading. Guessed.
constexpr std::size_t kMostPhotographs = 100;
constexpr std::size_t kMostExamples = 200;

// Copies have other times, so the content identifies a file: its length, and blocks at the beginning, in the
// middle and at the end.
std::string PhotographDigest(const LightField& light_field, const View& view) {
  std::error_code unknown;
  fs::path file = light_field.root / view.image_path;
  if (!view.master_path.empty() && !fs::exists(file, unknown)) file = light_field.root / view.master_path;
  if (!fs::is_regular_file(file, unknown)) return {};
  const std::uint64_t size = fs::file_size(file, unknown);
  std::ifstream stream(file, std::ios::binary);
  std::string bytes = std::to_string(size);
  constexpr std::size_t kBlock = 4096;
  for (const std::uint64_t part : {0, 1, 2})
    bytes += BytesAt(stream, part * (size > kBlock ? size - kBlock : 0) / 2, kBlock);
  return ChecksumText(ChecksumOf(bytes));
}

// Returns at most so many of the values, from the first to the last.
template <typename Value>
std::vector<Value> Evenly(const std::vector<Value>& values, std::size_t most) {
  if (values.size() <= most) return values;
  std::vector<Value> chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(values[i * values.size() / most]);
  return chosen;
}

KeptFinding Judged(const Finding& found, Check check, const LightField& light_field) {
  KeptFinding kept{found.check, found.text, found.views.empty(), {}};
  std::vector<const View*> views;
  for (const View& view : light_field.views)
    if (kept.whole || found.views.contains(view.id)) views.push_back(&view);
  if (kept.whole) views = Evenly(views, kMostExamples);
  for (const View* view : views)
    kept.views[view->id].pose =
        check == Check::kPoses ? ChecksumText(light_field.PoseDigest(*view)) : std::string();
  for (const View* view : Evenly(views, kMostPhotographs))
    kept.views[view->id].photograph = PhotographDigest(light_field, *view);
  return kept;
}

bool IsAsJudged(const JudgedView& judged, const View& view, const LightField& light_field) {
  return (judged.pose.empty() || judged.pose == ChecksumText(light_field.PoseDigest(view))) &&
         (judged.photograph.empty() || judged.photograph == PhotographDigest(light_field, view));
}

std::string WhyNotWritable(const fs::path& dir, const JournalContents& contents) {
  if (contents.whole_bytes != fs::file_size(dir / kJournalFile)) return "the end of its journal is damaged";
  if (CheckFolder(dir, contents, false).KnowsMoreThanJournal()) return "its journal has lost its end";
  return {};
}

}  // namespace

std::vector<Finding> StillValid(const std::vector<KeptFinding>& kept, const LightField& light_field) {
  std::vector<Finding> standing;
  for (const KeptFinding& each : kept) {
    Finding finding{each.check, each.text, {}};
    std::size_t as_judged = 0;
    for (const auto& [id, judged] : each.views) {
      const View* view = light_field.FindView(id);
      if (!view || !IsAsJudged(judged, *view, light_field)) continue;
      ++as_judged;
      if (!each.whole) finding.views[id] = view->image_path;
    }
    // Light is judged by comparison: nothing follows for views that are all alike.
    const bool has_others = each.check != Name(Check::kLight) || 2 * as_judged <= light_field.views.size();
    if (each.whole ? 2 * as_judged > each.views.size() : as_judged > 0 && has_others)
      standing.push_back(std::move(finding));
  }
  return standing;
}

std::string KeepFindings(const fs::path& dir, Check check, const std::vector<Finding>& found) {
  const fs::path file = dir / kJournalFile;
  std::error_code unknown;
  if (!fs::is_regular_file(file, unknown)) return "a set by another program is never written to";
  try {
    const auto is_same = [&](const KeptFinding& each) { return each.check == Name(check); };
    if (found.empty() && std::ranges::none_of(ReadJournal(file).kept_findings, is_same)) return {};
    Journal journal(file);
    const JournalContents contents = ReadJournal(file);
    if (std::string why = WhyNotWritable(dir, contents); !why.empty()) return why;
    std::vector<KeptFinding> kept, before;
    for (const Finding& each : found) kept.push_back(Judged(each, check, contents.light_field));
    std::ranges::copy_if(contents.kept_findings, std::back_inserter(before), is_same);
    if (kept != before) journal.NoteChecked(Name(check), kept);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace ulf
