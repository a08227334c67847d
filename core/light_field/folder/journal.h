// journal.jsonl: the append-only, authoritative record of a capture, one JSON object per line.
// docs/light_field.md has every event with its keys, their types, units and defaults, and an example.
//
// Every call syncs its lines before it returns; if the disk refuses a write, the whole call is undone
// (DiskFullError, Error). A damaged end (an incomplete last line, or lines after which no line is complete)
// was being written when the process died: readers ignore it, and the next writer cuts it off. A damaged line
// before the end is reported and ignored, but stays in the file; later lines are valid, because views do not
// depend on each other. The same holds for a complete line that names a path outside the folder, a camera or
// view that is not there, or an event of a newer version; a repair keeps such lines, too. followed_links.h
// handles links on the way to a photograph.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "core/light_field/light_field.h"

namespace ulf {

// A damaged line, or a run of them, and what may have been lost with them. In a journal with very many
// damaged places the last entry stands for all the rest.
struct DamagedLine {
  int number = 0;        // of the first line, from 1
  int last = 0;          // number of the last line
  int lines = 1;         // how many lines from the first to the last are damaged
  bool is_json = false;  // complete, but refused for its content; otherwise neighbours are one entry
  std::string reason;    // message with the line number
  std::set<int> views;   // ids of views that it may have recorded
  std::set<int> poses;   // ids of views whose poses it may have corrected, and no later line did
  bool IsWhole() const { return lines == last - number + 1; }  // false: sound lines lie between
  std::string Words() const;  // "line 7: damaged; the line is left out; view 6 is in doubt"
};

// The position of a line in the file.
struct JournalLine {
  std::size_t begin = 0, end = 0;  // in bytes, without its line end
  bool whole = false;              // complete and applied
  bool stays = false;              // complete but ignored; a repair keeps it
  int view_id = 0;                 // of a view's line that is complete or kept, else 0
};

// The content of a journal.
struct JournalContents {
  LightField light_field;
  // The cameras as noted, before any correction, indexed as LightField::cameras.
  std::vector<CameraModel> recorded_cameras;
  int next_view_id = 1;                 // above all ids used so far, including those of removed views
  std::size_t whole_bytes = 0;          // up to the end of the last complete line
  std::set<int> removed;                // ids of removed views
  std::set<std::string> removed_files;  // their photographs and masters
  std::vector<DamagedLine> damaged;
  std::size_t staying_lines = 0;   // number of damaged lines that a repair keeps
  std::vector<JournalLine> lines;  // up to whole_bytes
  // Derived files made from this many bytes are current: only findings follow.
  std::size_t derived_bytes = 0;
  std::vector<KeptFinding> kept_findings;  // the last of each check
};

// Its text ends with the advice to run `ulf repair`.
struct DamagedHeaderError : Error {
  DamagedHeaderError(const std::string& problem, const std::string& advice)
      : Error("{}; {}", problem, advice), problem(problem) {}
  std::string problem;
};

// Throws Error when the file cannot be read or begins with no header, NewerFormatError for a newer version.
JournalContents ReadJournal(const std::filesystem::path& file);
// Reads a journal whose header is damaged or missing, with the header's values from `header`.
JournalContents ReadJournal(const std::filesystem::path& file, const LightField& header);

// Appends lines to a journal, which it locks as long as it exists; the file is made if it is missing. A file
// with several hard links or a symbolic link (cp -al or cp -as of a light field) is copied before it is
// changed, so that the other light field stays as it is.
class Journal {
 public:
  // Throws Error if another Journal holds the lock, in this process or another, or the file cannot be opened.
  explicit Journal(const std::filesystem::path& file);

  // Removes what follows JournalContents::whole_bytes. Call it before anything is appended to an old journal.
  void CutAt(std::size_t whole_bytes);

  void Header(const LightField& light_field);
  // Adds a camera for later views, with the next free index.
  void AddCamera(int index, const NewCamera& camera);
  void AddViews(std::span<const View> views);  // a line each
  // Corrects poses by view id, and changed cameras by index.
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                   const std::map<int, CorrectedLens>& cameras = {});
  void AddExposure(int view_id, const ViewExposure& exposure);
  void NoteMerged(int view_id, const MergedExposures& merged);
  void SetSubject(const Subject& subject);
  void SetUp(const Eigen::Vector3d& up_in_world);
  void SetGoal(const CoverageGoal& goal);
  void SetReadout(const ShutterReadout& readout);
  void SetTurntable(const Turntable& turntable);
  // Sets the masks' paths by view id; others stay.
  void SetMasks(const std::map<int, std::string>& mask_path_by_view);
  // Notes a time in which nothing could be recorded, by the device's clock.
  void NoteGap(double from_s, double to_s, const std::string& reason);
  // Removes all of these views or, if the process is killed, none.
  void RemoveViews(const std::set<int>& view_ids);
  void NoteUnposed(const UnposedPhotograph& photograph);
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons,
             const std::optional<MeasuredErrors>& measured);
  // Replaces what a check found before; an empty list records that it found nothing.
  void NoteChecked(const std::string& check, const std::vector<KeptFinding>& found);
  // Appends lines of another journal unchanged; a line end is added at the end.
  void Append(const std::string& lines);
  // Appends a line about the repair, padded so that the journal has at least `bytes`. Otherwise derived files
  // made from the longer journal before the repair would seem to know more than this one.
  void NoteRepair(std::uint64_t bytes);

 private:
  void Open();
  void BreakHardLinks();
  std::filesystem::path file_;
  FileDescriptor descriptor_;
};

}  // namespace ulf
