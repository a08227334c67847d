// The state of a LightFieldWriter between its calls; only light_field_writer.cpp and the repair use it.
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
  // These serve LightFieldWriter::Create() and Resume().
  static std::unique_ptr<WriterState> Created(const std::filesystem::path& dir, const CaptureHeader& header);
  static std::unique_ptr<WriterState> Resumed(const std::filesystem::path& dir);

  explicit WriterState(const std::filesystem::path& dir) : journal(dir / kJournalFile), folder(dir) {
    light_field.root = dir;
  }
  // Makes a folder in the light field, which must still be where it was opened.
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
  int camera = 0;                             // index of the camera of later views
  std::vector<CameraModel> recorded_cameras;  // JournalContents::recorded_cameras
  // Files of views removed from the journal that are still to be moved, by view id: path to target.
  std::map<int, std::map<std::string, std::filesystem::path>> to_unposed;
  bool keep_mosaics = false;
  LockedWhiteBalance white_balance;
  std::set<int> moved_since_points;  // ids of views whose points must be computed again
};

// Returns a file's name in unposed/: NAME.master.tif for masters, which may have their photograph's ending.
std::filesystem::path UnposedName(const std::filesystem::path& file);

// Moves to unposed/ the files of removed views that a killed writer or a repair left in place.
void MoveRemoved(const std::filesystem::path& dir, const JournalContents& journal);

}  // namespace ulf
