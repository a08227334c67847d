// journal.jsonl: the append-only truth of a capture, one JSON object a line.
//
//   header {version, cameras, device_uri, device_serial, device_maker, device_model, sensor,
//   calibration_source, units, threshold_px, coverage_width_px} view {id, image, master, camera,
//   cam_from_world [qw qx qy qz tx ty tz], times, exposure, gain, quality, bound} pose_update {poses {id:
//   [7]}, cameras {index: as in the header}}   subject {center, radius}   up {up}   gap {from_s, to_s,
//   reason}   goal {cap_deg [2], share}   remove {id} close {capture_s, reasons}
//
// What a call writes is synced before it returns; what the disk refuses is taken back whole (DiskFullError,
// Error). A damaged end (a last line without its end, or lines after which none is whole) was being written
// when the process died: readers ignore it, the next writer cuts it off.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "acquisition/light_field.h"

namespace ulf {

// What a journal adds up to. `closed`: its last event is a close. `next_view_id`: removed ids are never given
// again.
struct JournalContents {
  LightField light_field;
  int next_view_id = 1;
  bool closed = false;
  std::size_t whole_bytes = 0;  // up to the end of the last whole line
};

// Throws Error naming file, line and key for damage anywhere but in the torn end.
JournalContents ReadJournal(const std::filesystem::path& file);

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

 private:
  void Append(const std::string& lines);

  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace ulf
