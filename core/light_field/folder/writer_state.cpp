#include "core/light_field/folder/writer_state.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/image/files/picture_kind.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/derived_files.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/leftovers.h"
#include "core/light_field/folder/quick_checks.h"
#include "core/light_field/folder/unused_folder.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Cuts off damaged lines at the journal's end; keeps them if they are more than one partial line.
void CutEnd(const fs::path& dir, const JournalContents& contents, Journal& journal) {
  const std::string bytes = ReadWholeFile(dir / kJournalFile);
  const std::string end = bytes.substr(std::min(contents.whole_bytes, bytes.size()));
  if (end.find('\n') != std::string::npos) {
    MakeFolder(dir / "kept");
    const fs::path copy = TemporaryName(dir / "kept" / "journal-end");
    WriteFileAtomically(copy, end);
    const fs::path kept = MoveWithoutReplacing(copy, dir / "kept" / "journal-end.jsonl");
    spdlog::warn("{}: its last lines are damaged and cut off; they are kept as {}",
                 (dir / kJournalFile).string(), kept.string());
  }
  journal.CutAt(contents.whole_bytes);
}

// Refuses a folder whose other files contain more than its journal, before anything is written.
void RequireWholeJournal(const fs::path& dir, const FolderCheck& check) {
  if (!check.KnowsMoreThanJournal()) return;
  std::string words;
  for (const std::string& each : check.words) words += each + "; ";
  throw Error("{}nothing was written; put it back with 'ulf repair {} --write', then go on", words,
              ShellWord(dir.string()));
}

// Refuses a journal that has lost more views than it has: further views would make another light field.
void RequireMostViews(const fs::path& dir, const JournalContents& contents) {
  std::set<int> lost;
  for (const DamagedLine& line : contents.damaged) lost.insert(line.views.begin(), line.views.end());
  if (lost.size() <= contents.light_field.views.size()) return;
  throw Error(
      "{}: {} of its {} cannot be read ({}); nothing was written; 'ulf repair {}' shows what can be put back",
      (dir / kJournalFile).string(), lost.size(),
      Counted(lost.size() + contents.light_field.views.size(), "view"), contents.damaged.front().reason,
      ShellWord(dir.string()));
}

// Refuses a journal if most photographs beside it are no views: it has lost its lines, and nothing else holds
// them.
void RequireMostPhotographs(const fs::path& dir, const JournalContents& contents, const FolderCheck& check) {
  constexpr std::size_t kUnderWay = 16;  // views that a kill may leave without their lines
  const auto unnamed = static_cast<std::size_t>(std::ranges::count_if(
      check.unnamed, [](const std::string& file) { return file.starts_with("images/"); }));
  if (unnamed <= std::max(kUnderWay, contents.light_field.views.size())) return;
  throw Error(
      "{}: names {}, and images/ holds {} that it does not name: it has lost its lines; nothing was written; "
      "put the journal back from a copy, or begin a new folder",
      (dir / kJournalFile).string(), Counted(contents.light_field.views.size(), "view"),
      Counted(unnamed, "photograph"));
}

void RequireMatchingPictures(const LightField& light_field) {
  const PictureCheck check = CheckPictures(light_field);
  if (check.damaged.size() > 1 && 2 * check.damaged.size() > light_field.views.size())
    throw Error(
        "{}: the photographs of {}, more than half of all, cannot be read; nothing was written; copy them "
        "again from their source, then go on",
        light_field.root.string(), ViewNumbers(check.damaged));
  if (!check.damaged.empty())
    spdlog::warn("{}: the photographs of {} cannot be read; 'ulf repair {}' shows the remedy",
                 light_field.root.string(), ViewNumbers(check.damaged), ShellWord(light_field.root.string()));
  if (check.others.empty()) return;
  throw Error(
      "{0}: the photographs in images/ of {1} differ from their masters, are damaged, or have another size "
      "than their camera; nothing was written; 'ulf repair {2}' shows the remedy",
      light_field.root.string(), ViewNumbers(check.others), ShellWord(light_field.root.string()));
}

// Uses for each camera the white balance of its first readable raw file.
void LockAsBefore(const LightField& light_field, LockedWhiteBalance& white_balance) {
  for (const View& view : light_field.views) {
    if (!IsRawFile(view.master_path)) continue;
    try {
      RawFacts facts = ReadRawFacts((light_field.root / view.master_path).string());
      facts.white_balance = view.raw_white_balance.value_or(facts.white_balance);
      white_balance.WhiteBalanceFor(facts);
    } catch (const Error&) {
      continue;
    }
  }
}

}  // namespace

fs::path UnposedName(const fs::path& file) {
  const fs::path folder = file.parent_path();
  const bool is_master = folder == "masters" || folder == kMergedFolder;
  return is_master ? fs::path(file.stem().string() + ".master" + file.extension().string()) : file.filename();
}

void WriterState::RequireReserved(int view_id, int last_id) const {
  if (view_id >= next_view_id)
    throw Error("{}: the number of view {} was not reserved", light_field.root.string(), view_id);
  if (view_id <= last_id)
    throw Error("{}: view {} cannot follow view {}", light_field.root.string(), view_id, last_id);
}

// Returns the paths of the view's files that exist, or can be made.
std::set<std::string> WriterState::FilesToKeep(const View& view) const {
  std::set<std::string> files = FilesOf(view);
  try {
    if (PictureFollowsFromMaster(view))
      WritePictureFromMaster(light_field.root, view, SizeOf(light_field.CameraOf(view)));
  } catch (const DiskFullError&) {
    throw;  // the caller can try again when there is room
  } catch (const Error& error) {
    spdlog::warn("{}; only the master of view {} is kept in unposed/", error.what(), view.id);
    files.erase(view.image_path);
  }
  return files;
}

// Omits views whose files are still to be moved: the caller repeats the moving alone.
void WriterState::TakeOutOfJournal(const std::set<int>& view_ids) {
  std::map<int, std::set<std::string>> files;
  std::set<int> ids;
  for (const int id : view_ids) {
    if (to_unposed.contains(id)) continue;
    const View* view = light_field.FindView(id);
    if (!view) throw Error("{}: there is no view {} to remove", light_field.root.string(), id);
    files[id] = FilesToKeep(*view);
    ids.insert(id);
  }
  const fs::path unposed = light_field.root / "unposed";
  MakeFolder("unposed");
  journal.RemoveViews(ids);  // before a file moves: the journal never names a missing file
  for (const auto& [id, paths] : files)
    for (const std::string& file : paths) to_unposed[id][file] = unposed / UnposedName(file);
  std::erase_if(light_field.views, [&](const View& view) { return ids.contains(view.id); });
  light_field.taken_back.insert(ids.begin(), ids.end());
}

void MoveRemoved(const fs::path& dir, const JournalContents& journal) {
  std::set<std::string> named;
  for (const View& view : journal.light_field.views) named.merge(FilesOf(view));
  for (const std::string& file : journal.removed_files) {
    if (file.empty() || named.contains(file) || !fs::is_regular_file(dir / file)) continue;
    MakeFolder(dir / "unposed");
    MoveWithoutReplacing(dir / file, dir / "unposed" / UnposedName(file));
  }
}

std::unique_ptr<WriterState> WriterState::Created(const fs::path& dir, const CaptureHeader& header) {
  std::error_code unknown;  // MakeFolder below reports the obstacle
  RequireForNewLightField(dir);
  const bool unused = IsUnused(dir);
  header.camera.Validate("the camera of " + dir.string());
  const bool made_folder = !fs::exists(dir, unknown);
  ulf::MakeFolder(dir / "images");
  auto state = std::make_unique<WriterState>(dir);
  if (unused) {
    RequireForNewLightField(dir);  // another process may have recorded into it before we held the lock
    state->journal.CutAt(0);
  }
  LightField& light_field = state->light_field;
  light_field.AddCamera(header);
  state->recorded_cameras = light_field.cameras;
  static_cast<CaptureFacts&>(light_field) = header;
  try {
    state->journal.Header(light_field);
    SyncFolder(dir);
  } catch (...) {
    // Without a recorded view no folder remains.
    fs::remove(dir / kJournalFile, unknown);
    fs::remove(dir / "images", unknown);
    if (made_folder) fs::remove(dir, unknown);
    throw;
  }
  return state;
}

std::unique_ptr<WriterState> WriterState::Resumed(const fs::path& dir) {
  if (!fs::is_regular_file(dir / kJournalFile)) throw MissingJournalError(dir);
  RequireFollowed(dir, RefusedLinks(dir, {}));
  auto state = std::make_unique<WriterState>(dir);
  JournalContents contents = ReadJournal(dir / kJournalFile);
  const FolderCheck check = CheckFolder(dir, contents, false);
  RequireImages(contents.light_field, check);
  RequireWholeJournal(dir, check);
  RequireMostViews(dir, contents);
  RequireMostPhotographs(dir, contents, check);
  RequireMatchingPictures(contents.light_field);
  WarnOnce(check.words);
  CutEnd(dir, contents, state->journal);
  RemoveLeftovers(dir, true);
  ReadPoints(contents.light_field);
  const std::vector<std::string> point_doubts = contents.light_field.doubts;
  WarnOnce(point_doubts);
  AddKnownFindings(contents.kept_findings, contents.light_field);
  MoveRemoved(dir, contents);
  state->light_field = std::move(contents.light_field);
  state->recorded_cameras = std::move(contents.recorded_cameras);
  state->camera = static_cast<int>(state->light_field.cameras.size()) - 1;
  LockAsBefore(state->light_field, state->white_balance);
  state->light_field.doubts = check.words;
  state->light_field.doubts.insert(state->light_field.doubts.end(), point_doubts.begin(), point_doubts.end());
  // A number in any file name is never used again, even if the journal does not contain it.
  state->next_view_id = std::max(contents.next_view_id, check.highest_number + 1);
  ulf::MakeFolder(dir / "images");
  MakeMissingPictures(state->light_field);
  KeepForeignFiles(dir, check, !point_doubts.empty());
  WriteDerivedFilesOrWarn(state->light_field);
  return state;
}

}  // namespace ulf
