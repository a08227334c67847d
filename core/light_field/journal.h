// journal.jsonl: the append-only truth of a capture, one JSON object a line. docs/disk_format.md has every key
// with its type, unit and default, and an example of each line:
//
//   header       {version, cameras, device_uri, device_serial, device_maker, device_model, sensor,
//                 calibration_source, units, threshold_px, coverage_width_px}
//   view         {id, image, master, mask, camera, cam_from_world [qw qx qy qz tx ty tz], times, exposure,
//                 gain, quality, bound}
//   pose_update  {poses {id: [7]}, cameras {index: as in the header}}
//   subject      {center, radius}
//   up           {up}
//   goal         {cap_deg [2], share}
//   gap          {from_s, to_s, reason}
//   remove       {id}
//   close        {capture_s, reasons}
//   repaired     {}
//
// What a call writes is synced before it returns; what the disk refuses is taken back whole (DiskFullError,
// Error). A damaged end (a last line without its end, or lines after which none is whole) was being written
// when the process died: readers ignore it, the next writer cuts it off. A damaged line before that is left
// out, named, and stays where it is; what follows it counts, since views do not depend on each other.
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

// How much of a journal something was made from: its length and the CRC-32 of that much. What is derived
// carries it, so that a journal that has lost its end, or was changed, is noticed.
struct JournalStamp {
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;
  bool operator==(const JournalStamp&) const = default;
};

// The stamp of the first `bytes` of FILE; none where it is shorter or cannot be read.
std::optional<JournalStamp> StampOf(const std::filesystem::path& file, std::uint64_t bytes);
// Of all of it.
std::optional<JournalStamp> StampOf(const std::filesystem::path& file);

// A line that could not be read, and what may have been lost with it.
struct DamagedLine {
  int number = 0;             // from 1
  std::string reason;         // with its number
  std::set<int> views;        // that it may have recorded
  std::set<int> poses;        // that it may have corrected, and no later line did
  std::string Words() const;  // "line 7: damaged; the line is left out; view 6 is in doubt"
};

// A line as it stands in the file.
struct JournalLine {
  std::size_t begin = 0, end = 0;  // without its line end
  bool whole = false;
  int view_id = 0;  // of a view's line that is whole, else 0
};

// What a journal adds up to.
struct JournalContents {
  LightField light_field;
  int next_view_id = 1;         // above all that were ever given; those of removed views are not given again
  std::size_t whole_bytes = 0;  // up to the end of the last whole line
  std::set<int> removed;        // ids of views that were taken out
  std::set<std::string> removed_files;  // their photographs and masters
  std::vector<DamagedLine> damaged;
  std::vector<JournalLine> lines;  // up to whole_bytes
};

// Throws Error where the file cannot be read, or where its first line is no header of a version that this
// program knows.
JournalContents ReadJournal(const std::filesystem::path& file);
// With another header's values in place of its own, which is damaged or missing: `header` without views.
JournalContents ReadJournal(const std::filesystem::path& file, const LightField& header);

// Holds the file open and locked. A second writer, in this process or another, gets an Error.
class Journal {
 public:
  explicit Journal(const std::filesystem::path& file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Drops what follows the last whole line; before the first append to a journal that was there already.
  void CutAt(std::size_t whole_bytes);

  void Header(const LightField& light_field);
  void AddViews(std::span<const View> views);  // a line each
  // Poses by view, and the cameras that changed with them.
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                   const std::map<int, CameraModel>& cameras = {});
  void SetSubject(const Subject& subject);
  void SetUp(const Eigen::Vector3d& up_in_world);
  void SetGoal(const CoverageGoal& goal);
  void NoteGap(double from_s, double to_s, const std::string& reason);
  void RemoveView(int view_id);
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons);
  // Lines of another journal, as they are.
  void Append(const std::string& lines);
  // A line that says that the journal was repaired, so long that the journal has at least `bytes`: what was
  // made from a longer one would else be taken for newer.
  void NoteRepair(std::uint64_t bytes);

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace ulf
