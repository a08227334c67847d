// Checks that the files of a light field agree. The journal is authoritative. Derived files (transforms.json,
// sparse/0) contain the stamp of the journal that they were made from, which distinguishes an older file from
// a changed one, and from a journal that has lost its end. docs/light_field.md ("Which file is used") has the
// table of facts, precedence and messages.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/light_field/folder/followed_links.h"
#include "core/light_field/folder/journal.h"

namespace ulf {

// The relation of a derived file to the present journal.
enum class Lineage {
  kMissing,
  kUnreadable,
  kCurrent,       // made from the whole journal
  kOlder,         // made from its beginning: lines have been added since
  kJournalShort,  // made from a longer journal: the journal has lost its end
  kJournalOther,  // made from other content: the journal was damaged or edited
  kUnknown,       // without a stamp: written by an older version
  kForeign        // written by another program
};

// The differences between one derived file and the journal.
struct Derived {
  Lineage lineage = Lineage::kMissing;
  std::string problem;              // why it is kUnreadable
  std::map<int, View> unknown;      // views, by id, that the journal neither contains nor removed
  std::map<int, View> other_poses;  // views whose poses differ
  std::map<int, View> lost_poses;   // those of other_poses whose corrections were in damaged journal lines
  bool other_cameras = false;
  bool is_cut = false;                // the file lacks its end
  std::uint64_t made_from_bytes = 0;  // length of the journal; 0: unknown
  // Returns whether the file contains views or poses that the journal has lost.
  bool KnowsMoreThanJournal() const;
  // Returns whether another program or a person has changed it.
  bool WasChanged() const;
  // Returns whether it can be replaced without loss.
  bool IsOurs() const { return !KnowsMoreThanJournal() && !WasChanged() && lineage != Lineage::kUnreadable; }
};

struct FolderCheck {
  Derived transforms, model;                  // transforms.json and sparse/0
  std::optional<LightField> from_transforms;  // none: missing, unreadable or not checked
  std::vector<std::string> unnamed;  // numbered photographs and masters that the journal does not name
  std::set<int> missing_masters;     // views with a photograph whose master is missing
  std::set<int> unmade_images;       // views whose photograph is missing and can be made from their master
  std::set<int> missing_images;      // views whose photograph and master are missing
  std::vector<OutsideLink> refused_links;  // links out of the folder, whose targets were not examined
  int highest_number = 0;                  // the highest view number in a file name of the folder
  bool not_closed = false;                 // derived files are missing or older
  std::vector<std::string> words;          // messages; empty: no problem
  std::vector<std::string> problems;       // the same without the advice to run `ulf repair`
  bool KnowsMoreThanJournal() const {
    return transforms.KnowsMoreThanJournal() || model.KnowsMoreThanJournal();
  }
};

// Compares the files of `dir`, and changes none. While a writer is active (`being_written`), checks only what
// the writer does not change. If links are refused, checks nothing else.
FolderCheck CheckFolder(const std::filesystem::path& dir, const JournalContents& journal, bool being_written);

// Throws Error if photographs are missing, or behind links that are refused.
void RequireImages(const LightField& light_field, const FolderCheck& check);

// Returns whether derived files with a journal's stamp exist without the journal; `ulf repair` restores it.
bool IsJournalMissing(const std::filesystem::path& dir);
// Returns an Error for a writer about a folder without a journal, with the remedy: a light field that has
// lost it, a data set of another program, or neither.
Error MissingJournalError(const std::filesystem::path& dir);

// Ids of views with defective pictures.
struct PictureCheck {
  std::set<int> others;   // the photograph differs from its master, is unreadable although its master is
                          // readable, or has another size than its camera
  std::set<int> damaged;  // the photograph is unreadable and cannot be made from a master
  std::set<int> damaged_masters;  // the master is unreadable
};

// Decodes and compares all photographs and masters, in several threads.
PictureCheck CheckPictures(const LightField& light_field);

}  // namespace ulf
