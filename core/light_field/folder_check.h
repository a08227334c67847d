// Whether the files of a light field that tell the same fact tell it alike. The journal is the truth; what is
// derived from it (transforms.json, sparse/0) carries the stamp of the journal that it was made from, which
// tells a file that is only older from one that was changed, and from a journal that has lost its end.
// docs/light_field.md has the table of facts, of what wins, and of what is said.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/journal.h"

namespace ulf {

// How a derived file stands to the journal as it is now.
enum class Lineage {
  kMissing,
  kUnreadable,
  kCurrent,       // made from all of it
  kOlder,         // from the beginning of it: lines have been added since
  kJournalShort,  // from more than there is: the journal has lost its end
  kJournalOther,  // from another one: the journal was damaged or edited
  kUnknown,       // it has no stamp: an older version's
  kForeign        // another program's
};

// What one derived file says otherwise than the journal.
struct Derived {
  Lineage lineage = Lineage::kMissing;
  std::string problem;              // why it is unreadable
  std::map<int, View> unknown;      // views that the journal neither has nor took out
  std::map<int, View> other_poses;  // views whose poses differ
  std::map<int, View> lost_poses;   // of these, corrections whose lines in the journal are damaged
  bool other_cameras = false;
  bool is_cut = false;                // its end is missing
  std::uint64_t made_from_bytes = 0;  // of the journal; 0: it does not say
  // The journal has lost what this file still holds.
  bool HoldsWhatIsLost() const;
  // Somebody else has written it.
  bool WasChanged() const;
  // Nothing of it would be missed if it were written anew.
  bool IsOurs() const { return !HoldsWhatIsLost() && !WasChanged() && lineage != Lineage::kUnreadable; }
};

struct FolderCheck {
  Derived transforms, model;
  std::optional<LightField> from_transforms;  // what it says, where it can be read
  std::vector<std::string> unnamed;  // numbered photographs and masters that the journal does not name
  std::vector<int> missing_masters;  // views whose master is gone
  std::vector<int> missing_images;   // views whose photograph is gone, with its master
  int highest_number = 0;            // that any file of the folder bears
  bool not_closed = false;           // derived files are missing or older
  std::vector<std::string> words;    // sentences; empty: all is as it should be
  bool HoldsWhatIsLost() const { return transforms.HoldsWhatIsLost() || model.HoldsWhatIsLost(); }
};

// Reads, writes nothing. While somebody is writing, only what cannot change under his hands is looked at.
FolderCheck CheckFolder(const std::filesystem::path& dir, const JournalContents& journal, bool being_written);

// Views by what is wrong with their pictures.
struct PictureCheck {
  std::vector<int> others;   // the photograph is not the master's, or cannot be read while the master can; or
                             // it has not its camera's size
  std::vector<int> damaged;  // the photograph cannot be read, nor is there a master to make it from
  std::vector<int> damaged_masters;  // the master cannot be read
};

// Photographs and masters decoded and compared, in several threads.
PictureCheck CheckPictures(const LightField& light_field);

}  // namespace ulf
