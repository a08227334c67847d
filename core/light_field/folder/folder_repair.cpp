#include "core/light_field/folder/repair_plan.h"

#include <algorithm>
#include <cerrno>
#include <limits>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/light_field/folder/derived_files.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/leftovers.h"
#include "core/light_field/folder/writer_state.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

std::vector<View> ViewsOf(const LightField& light_field, const std::set<int>& ids) {
  std::vector<View> views;
  for (const View& view : light_field.views)
    if (ids.contains(view.id)) views.push_back(view);
  return views;
}

void MoveToUnposed(const fs::path& dir, const View& view) {
  MakeFolder(dir / "unposed");
  MoveWithoutReplacing(dir / view.image_path, dir / "unposed" / fs::path(view.image_path).filename());
}

// Copies the old lines unchanged and inserts the recovered views by their numbers, so that later corrections
// apply to them.
void WriteLines(const fs::path& old_journal, const JournalContents& contents, const RepairPlan& plan,
                Journal& to) {
  const std::string bytes = contents.lines.empty() ? "" : ReadWholeFile(old_journal);
  std::string lines;
  auto next = plan.recovered.begin();
  const int known_cameras = static_cast<int>(contents.light_field.cameras.size());
  bool has_new_cameras = false;
  const auto flush = [&] {
    if (!lines.empty()) to.Append(lines.substr(0, lines.size() - 1));
    lines.clear();
  };
  const auto recover_below = [&](int id) {
    std::vector<View> views;
    for (; next != plan.recovered.end() && next->first < id; ++next) views.push_back(next->second);
    if (views.empty()) return;
    flush();
    const auto is_under_new = [&](const View& view) { return view.camera >= known_cameras; };
    if (!has_new_cameras && std::ranges::any_of(views, is_under_new)) {
      has_new_cameras = true;
      for (std::size_t i = 0; i < plan.new_cameras.size(); ++i)
        to.AddCamera(known_cameras + static_cast<int>(i), plan.new_cameras[i]);
    }
    to.AddViews(views);
  };
  for (const JournalLine& line : contents.lines) {
    if (!line.whole && (!line.stays || plan.recovered.contains(line.view_id))) continue;
    if (line.view_id > 0) recover_below(line.view_id);
    lines.append(bytes, line.begin, line.end - line.begin + 1);
  }
  recover_below(std::numeric_limits<int>::max());
  flush();
}

void WriteSettings(const LightField& lost, const LightField& known, Journal& to) {
  if (lost.up_in_world && !known.up_in_world) to.SetUp(*lost.up_in_world);
  if (lost.goal && lost.goal != known.goal) to.SetGoal(*lost.goal);
  if (lost.readout && lost.readout != known.readout) to.SetReadout(*lost.readout);
  if (lost.turntable && lost.turntable != known.turntable) to.SetTurntable(*lost.turntable);
  if (lost.subject && lost.subject != known.subject) to.SetSubject(*lost.subject);
  if (lost.capture_s > 0) to.Close(lost.capture_s, lost.reasons, lost.measured);
}

void WriteNewJournal(const fs::path& dir, const RepairPlan& plan, Journal& to) {
  const JournalContents old = ReadDamagedJournal(dir);
  to.CutAt(0);
  if (plan.header) to.Header(*plan.header);
  WriteLines(dir / kJournalFile, old, plan, to);
  if (!plan.poses.empty() || !plan.cameras.empty()) to.UpdatePoses(plan.poses, plan.cameras);
  to.RemoveViews(plan.taken_out);
  to.NoteRepair(plan.longest_stamp);
  if (plan.settings) WriteSettings(*plan.settings, old.light_field, to);
}

// The new journal replaces the old one atomically; a hard link keeps the old content.
void Exchange(const fs::path& dir) {
  if (fs::exists(dir / kJournalFile)) {
    MakeFolder(dir / "kept");
    int number = 1;
    while (!LinkOrCopy(dir / kJournalFile, dir / "kept" / fmt::format("journal-{}.jsonl", number))) ++number;
    SyncFolder(dir / "kept");
  }
  if (rename((dir / kNewJournal).c_str(), (dir / kJournalFile).c_str()) != 0)
    ThrowDiskError(errno, (dir / kJournalFile).string() + ": cannot be replaced");
  SyncFolder(dir);
}

// Removes what killed writers left of a folder that needs no repair.
void TidyUp(const fs::path& dir) {
  if (!fs::is_regular_file(dir / kJournalFile) || !RefusedLinks(dir, {}).empty()) return;
  try {
    const Journal lock(dir / kJournalFile);
    RemoveLeftovers(dir, true);
    MoveRemoved(dir, ReadJournal(dir / kJournalFile));
  } catch (const Error&) {
    // A folder that cannot be written to, or that a capture holds, stays as it is.
  }
}

}  // namespace

RepairPlan Repair(const fs::path& dir) {
  if (RepairPlan plan = PlanRepair(dir); !plan.any()) {
    TidyUp(dir);
    return plan;
  }
  // Every writer locks the journal, or the one that will replace it.
  std::optional<Journal> old_journal;
  if (fs::is_regular_file(dir / kJournalFile)) old_journal.emplace(dir / kJournalFile);
  RemoveLeftovers(dir, old_journal.has_value());
  std::optional<Journal> new_journal(std::in_place, dir / kNewJournal);
  RepairPlan plan = PlanRepair(dir);
  try {
    if (plan.new_journal) {
      WriteNewJournal(dir, plan, *new_journal);
      const std::size_t views = ReadJournal(dir / kNewJournal).light_field.views.size();
      // There are more if a recovered camera makes views readable again.
      if (views < plan.views_after)
        throw Error("{}: the repaired journal would have {} instead of {}; nothing was changed", dir.string(),
                    Counted(views, "view"), plan.views_after);
      plan.views_after = views;
      Exchange(dir);
    } else {
      fs::remove(dir / kNewJournal);
    }
  } catch (...) {
    std::error_code gone;
    fs::remove(dir / kNewJournal, gone);
    throw;
  }
  const JournalContents contents = ReadJournal(dir / kJournalFile);
  LightField light_field = contents.light_field;
  for (const View& view : ViewsOf(light_field, plan.pictures_of_others)) MoveToUnposed(dir, view);
  MoveRemoved(dir, contents);
  MakeFolder(dir / "images");
  if (const std::size_t missing = MakeMissingPictures(light_field); missing > 0) {
    std::erase(plan.steps, kMakePicturesStep);
    plan.not_done.push_back(fmt::format("make {} from their masters (see the reasons above)",
                                        Counted(missing, "missing photograph")));
  }
  if (plan.new_derived) {
    const FolderCheck check = CheckFolder(dir, contents, false);
    if (!check.transforms.IsOurs() || plan.other_transforms)
      MoveToKept(dir, kTransformsFile, kTransformsFile);
    if (!check.model.IsOurs() || plan.other_model) MoveToKept(dir, "sparse/0", "sparse");
    ReadPoints(light_field);
    if (!light_field.doubts.empty())
      for (const char* points : {"points.ply", "points.ulf"}) MoveToKept(dir, points, points);
    WriteDerivedFiles(light_field);
  }
  return plan;
}

}  // namespace ulf
