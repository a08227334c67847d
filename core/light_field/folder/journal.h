// journal.jsonl: the append-only, authoritative record of a capture, one JSON object per line.
// docs/light_field.md has every key with its type, unit and default, and an example of each line:
//
//   header       {version, cameras, device_uri, device_serial, device_maker, device_model, sensor,
//                 units, threshold_px, coverage_width_px}
//   camera       {index, camera as in the header}
//   view         {id, image, master, mask, camera, cam_from_world [qw qx qy qz tx ty tz], times, exposure,
//                 gain, quality, bound, twist}
//   pose_update  {poses {id: [7]}, cameras {index: as in the header}}
//   exposure     {view, image, master, times, exposure, gain, exposure_from_view [7], pose}
//   merged       {view, image, exposures, ghosts}
//   subject      {center, radius}
//   up           {up}
//   goal         {cap_deg [2], share}
//   readout      {readout_s, sigma_s}
//   turntable    {board}
//   masks        {masks {id: path}}
//   gap          {from_s, to_s, reason}
//   remove       {id}, or of several together {ids []}
//   unposed      {image, master, camera, times, exposure, gain, problem}
//   close        {capture_s, reasons, measured}
//   checked      {check, found [{text, whole, views {id: {photograph, pose}}}]}
//   repaired     {}
//
// Every call syncs its lines before it returns; when the disk refuses a write, the whole call is undone
// (DiskFullError, Error). A damaged end (an incomplete last line, or lines after which no line is complete)
// was being written when the process died: readers ignore it, and the next writer cuts it off. A damaged line
// before the end is reported and left out, but stays in the file; later lines are valid, because views do not
// depend on each other. So is a line that is whole and names a path outside the folder or an event of a newer
// version; a repair keeps such lines, too. Links on the way to a photograph are followed_links.h's concern.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// A damaged line, or damaged lines behind each other, and what may have been lost with them.
struct DamagedLine {
  int number = 0;       // from 1
  int last = 0;         // the last one's number
  int lines = 1;        // damaged ones among them
  std::string reason;   // message with the line number
  std::set<int> views;  // views that it may have recorded
  std::set<int> poses;  // views whose poses it may have corrected, and no later line did
  bool IsWhole() const { return lines == last - number + 1; }  // else it stands for many places
  std::string Words() const;  // "line 7: damaged; the line is left out; view 6 is in doubt"
};

// The position of a line in the file.
struct JournalLine {
  std::size_t begin = 0, end = 0;  // without its line end
  bool whole = false;
  bool stays = false;  // whole but left out; a repair keeps it
  int view_id = 0;     // of a view's line that is whole or stays, else 0
};

// The content of a journal.
struct JournalContents {
  LightField light_field;
  // LightField::cameras, by the same index, as they were noted, before any correction.
  std::vector<CameraModel> recorded_cameras;
  int next_view_id = 1;                 // above all ids used so far, including those of removed views
  std::size_t whole_bytes = 0;          // up to the end of the last complete line
  std::set<int> removed;                // ids of removed views
  std::set<std::string> removed_files;  // their photographs and masters
  std::vector<DamagedLine> damaged;     // of very many places the last entry stands for all further ones
  std::size_t staying_lines = 0;        // among the damaged ones
  std::vector<JournalLine> lines;       // up to whole_bytes
  // Derived files that were made from so many bytes hold all: what follows says what checks found.
  std::size_t derived_bytes = 0;
  std::vector<KeptFinding> kept_findings;  // the last of each check
};

// Throws Error when the file cannot be read or its first line is no header of a supported version.
JournalContents ReadJournal(const std::filesystem::path& file);
// For a journal whose header is damaged or missing: takes the header's values from `header`.
JournalContents ReadJournal(const std::filesystem::path& file, const LightField& header);

// Opens and locks the file for writing. A second writer, in this process or another, gets an Error. A file
// that other names share (cp -al or cp -as of a light field) is copied before it is changed, so that the
// other light field stays as it is.
class Journal {
 public:
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Removes a damaged end; to be called before the first append to an existing journal.
  void CutAt(std::size_t whole_bytes);

  void Header(const LightField& light_field);
  // The camera that later views may name: its index is the number of cameras that there are.
  void AddCamera(int index, const NewCamera& camera);
  void AddViews(std::span<const View> views);  // a line each
  // Poses by view id, and changed cameras by index.
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                   const std::map<int, CorrectedLens>& cameras = {});
  void AddExposure(int view_id, const ViewExposure& exposure);
  void NoteMerged(int view_id, const MergedExposures& merged);
  void SetSubject(const Subject& subject);
  void SetUp(const Eigen::Vector3d& up_in_world);
  void SetGoal(const CoverageGoal& goal);
  void SetReadout(const ShutterReadout& readout);
  void SetTurntable(const Turntable& turntable);
  // The masks' paths by view id; others stay as they are.
  void SetMasks(const std::map<int, std::string>& mask_path_by_view);
  void NoteGap(double from_s, double to_s, const std::string& reason);
  // Removes all of them or, when the process is killed, none.
  void RemoveViews(const std::set<int>& view_ids);
  void NoteUnposed(const UnposedPhotograph& photograph);
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons,
             const std::optional<MeasuredErrors>& measured);
  // What a check found, in place of what it found before; nothing: it was looked at again.
  void NoteChecked(const std::string& check, const std::vector<KeptFinding>& found);
  // Appends lines of another journal unchanged.
  void Append(const std::string& lines);
  // Appends a line about the repair, padded so that the journal has at least `bytes`. Otherwise derived files
  // that were made from the longer journal would look newer.
  void NoteRepair(std::uint64_t bytes);

 private:
  void Open();
  void BecomeTheOnlyName();
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace ulf
