// Plans the repair of a light field's folder (`ulf repair`) from the content of its files, and does it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/folder/journal.h"
#include "core/light_field/light_field.h"

namespace ulf {

// The step that Repair() moves from `steps` to `not_done` when it fails.
inline constexpr const char* kMakePicturesStep = "make the photographs that are missing from their masters";

struct RepairPlan {
  std::vector<std::string> found;     // problems
  std::vector<std::string> steps;     // what Repair() does; empty: nothing can or need be done
  std::vector<std::string> not_done;  // steps that Repair() could not do
  std::size_t views_before = 0, views_after = 0, damaged_lines = 0;

  // The content of the steps:
  std::optional<LightField> header;      // for a journal without one
  std::string header_from;               // the file that the header is from
  std::map<int, View> recovered;         // views for the journal, by id
  std::vector<NewCamera> new_cameras;    // of some of these views; their indices follow the journal's own
  std::map<int, Rigid3> poses;           // corrected poses of views in the journal, by id
  std::map<int, CorrectedLens> cameras;  // corrected cameras of the journal, by index
  std::set<int> taken_out;               // ids of views whose photograph is missing or damaged
  std::set<int> pictures_of_others;      // ids of views whose photograph differs from its master
  std::optional<LightField> settings;    // lost subject, up, goal, readout, turntable, times and counts
  std::uint64_t longest_stamp = 0;       // bytes of the longest journal that a derived file was made from
  bool new_journal = false, new_derived = false, missing_pictures = false;
  bool damaged_points = false, other_transforms = false, other_model = false;  // files that go to kept/
  bool any() const { return !steps.empty(); }
};

// Changes nothing. Throws Error if the folder contains no light field, NewerFormatError for a newer ulf's.
RepairPlan PlanRepair(const std::filesystem::path& dir);

// Reads the readable part of the journal, with a header from transforms.json or sparse/0 if its own is lost.
// Throws Error if none of them contains the cameras.
JournalContents ReadDamagedJournal(const std::filesystem::path& dir);

// Executes the plan of PlanRepair() under the lock of the journal and returns it: restores views that the
// journal has lost from transforms.json or sparse/0, makes photographs that differ from their masters again,
// and writes all derived files. Nothing is deleted: replaced files go to kept/, files of removed views to
// unposed/. A process killed at any moment leaves the old journal or the new one. Throws DiskFullError, Error
// (also if a writer is active); files that were moved to kept/ stay there.
RepairPlan Repair(const std::filesystem::path& dir);

}  // namespace ulf
