// What a LightFieldWriter knows between its calls.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/image/files/raw_file.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/opened_folder.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"

namespace ulf {

struct WriterState {
  // A new light field in DIR, or an old one for more views: LightFieldWriter::Create() and Resume().
  static std::unique_ptr<WriterState> Created(const std::filesystem::path& dir, const CaptureHeader& header);
  static std::unique_ptr<WriterState> Resumed(const std::filesystem::path& dir);

  explicit WriterState(const std::filesystem::path& dir) : journal(dir / kJournalFile), folder(dir) {
    light_field.root = dir;
  }
  // A folder of the light field, which must still be where it was opened.
  void MakeFolder(const std::filesystem::path& inside) const {
    folder.RequireInPlace();
    MakeFolderIn(light_field.root, inside);
  }
  void TakeOutOfJournal(const std::set<int>& view_ids);
  std::set<std::string> FilesToKeep(const View& view) const;
  void RequireReserved(int view_id, int last_id) const;

  Journal journal;
  OpenedFolder folder;
  LightField light_field;
  std::atomic<int> next_view_id = 1;
  int next_unposed = 1;
  int camera = 0;                             // under which views are recorded
  std::vector<CameraModel> recorded_cameras;  // JournalContents::recorded_cameras
  // Of views that the journal no longer names, by id: files that are still to be moved, and their targets.
  std::map<int, std::map<std::string, std::filesystem::path>> to_unposed;
  bool keep_mosaics = false;
  LockedWhiteBalance white_balance;
  std::set<int> moved_since_points;  // views
};

// The name in unposed/: of a master beside the photograph's, which may have the same ending.
std::filesystem::path UnposedName(const std::filesystem::path& file);

// Moves to unposed/ the files of views that the journal has removed, where a killed writer or a repair left
// them.
void MoveRemoved(const std::filesystem::path& dir, const JournalContents& journal);

}  // namespace ulf
