// Writes recorded views to disk: a bounded queue, threads that encode, and one thread that writes.
//
// The spool writes every accepted view, in the order of acceptance. It accepts no more while the disk is slow
// (the queue is full) or full (no room for the waiting views and for closing); Pause() says which. A write
// that fails for lack of room is tried again until there is room, or until Finish(). The spool looks for room
// before it accepts a view, so that accepted views normally fit. Any other error (permissions, a folder that
// was moved or deleted) is a Failure(): the spool then records no more views, puts the accepted ones into
// unposed/, or else beside the light field, and counts those that fit in neither place: Unwritten(). It never
// makes a folder under the old name.
//
// Views that wait together are written together (LightFieldWriter::AddViews). A view with a master is
// recorded when its master and its journal line are on disk. Making its photograph in images/ takes ten times
// as long: low-priority threads make it from the master, and Finish() waits for them. A photograph that
// cannot be made is reported and blocks nothing: the next program that opens the light field for writing
// makes it.
//
// A killed process loses the views that were not on disk: up to eight that were being written, and those that
// waited behind them, at most as many as the capacity (photographs of a tethered camera come on top).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/frames/frame.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/opened_folder.h"

namespace ulf::coverage {

// Describes why the spool accepts no view at the moment.
struct SpoolPause {
  bool disk_is_full = false;  // false: the disk is slow
  std::string words;          // for people
};

class ViewSpool {
 public:
  // `capacity`: of the queue, counting views and everything else that is to be written. Without threads every
  // write happens inside the call, including photographs in images/.
  ViewSpool(LightFieldWriter writer, std::size_t capacity, bool threaded);
  ~ViewSpool();
  ViewSpool(const ViewSpool&) = delete;
  ViewSpool& operator=(const ViewSpool&) = delete;

  // Returns the id reserved for the view, even after a Failure(); none when there is no room.
  std::optional<int> TryAddView(const Frame& frame, const View& view);
  // Accepts the view although there is no room, and writes it when there is: for photographs, which come
  // seldom. Ask Pause() before asking the camera for one.
  int AddView(const Frame& frame, const View& view);
  void KeepUnposed(const Frame& frame, const std::string& problem = "");  // LightFieldWriter::KeepUnposed()
  // Adds another exposure of a view, as LightFieldWriter::AddExposure() does: even without room, as for
  // photographs.
  void AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view, bool pose_is_between);
  // Reserves room in the files that closing writes for so many points of a view.
  void ExpectSeenPoints(std::size_t points) {
    most_seen_points_ = std::max<std::uint64_t>(most_seen_points_, points);
  }
  // Takes added views out of the light field together, whether they are on disk or waiting. They are written
  // first, so that their photographs are not lost, and then move to unposed/.
  void RemoveViews(std::set<int> ids);
  // Journals those of the poses (by view id) that differ from what is on disk. Returns false when the queue
  // is full: try again later.
  bool TryUpdatePoses(std::map<int, Rigid3> cam_from_world);
  // Journals the poses together with their lens and its source: in one line, before any view that is added
  // later. Only Try...() need room in the queue.
  void UpdateLens(const CameraModel& camera, const std::string& source, std::map<int, Rigid3> cam_from_world);
  void SetSubject(const Subject& subject);
  void NoteGap(double from_s, double to_s, const std::string& reason);  // LightFieldWriter::NoteGap()

  // Returns none when the spool accepts views, and after a failure.
  std::optional<SpoolPause> Pause();
  // Returns the error that ended recording, if there was one.
  std::optional<std::string> Failure() const;
  // Returns the number of frames (views, other exposures, and frames for unposed/) accepted and not written.
  std::size_t ViewsWaiting() const;
  // Returns the number of photographs in images/ that are still to be made from their masters.
  std::size_t PicturesWaiting() const;
  // Writes the rest without waiting for room, and returns the writer. Failure() then says why something did
  // not fit; a missing photograph in images/ is made when the light field is next opened for writing.
  LightFieldWriter Finish();
  // Returns an upper bound of the bytes that a view of this frame takes on disk.
  static std::uint64_t MostBytes(const Frame& frame);
  // Returns, after Finish(), the number of accepted frames that are nowhere on disk.
  std::size_t Unwritten() const;
  // Returns, after Finish(), the number of accepted frames written to other folders, by folder.
  std::map<std::filesystem::path, std::size_t> SetAside() const;
  // Returns the light field's folder.
  const OpenedFolder& Folder() const { return folder_; }

 private:
  struct PendingView {
    LightFieldWriter::NewView view;
    enum { kWaiting, kBeingEncoded, kEncoded } state = kWaiting;  // under mutex_
    std::exception_ptr problem;                                   // of encoding
  };
  // A line, a view, a frame for unposed/, or another exposure of a view.
  struct Task {
    std::function<void(LightFieldWriter&)> write;  // of all but a view
    std::shared_ptr<PendingView> view = {};
    std::optional<Frame> other_frame = {};
    bool is_for_unposed = false;
    bool IsFrame() const { return view || other_frame; }
  };
  enum class Outcome { kWritten, kNoRoom, kFailed };
  Task Adding(const Frame& frame, const View& view);
  bool Submit(Task task, bool only_if_room);
  bool WriteInCaller(bool only_if_room);
  Outcome Write(std::span<const Task> tasks);
  void WriteViews(std::span<const Task> tasks);
  Outcome Try(const std::function<void()>& write, std::string& problem);
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world, const std::map<int, CorrectedLens>& cameras);
  void Remove(const std::set<int>& ids);
  bool Rescue(const Task& task);
  void RemoveFirst(bool written) ULF_REQUIRES(mutex_);
  void StopThreads();
  void WriteLoop();
  void EncodeLoop();
  void PictureLoop();
  std::size_t BatchSize(std::size_t most_views) const ULF_REQUIRES(mutex_);
  std::uint64_t NeededBytes(std::uint64_t views) const ULF_REQUIRES(mutex_);

  LightFieldWriter writer_;
  const std::filesystem::path root_;
  const OpenedFolder folder_;
  const std::size_t capacity_;
  const bool threaded_;
  std::atomic<std::uint64_t> largest_view_bytes_{0}, largest_picture_bytes_{0}, views_on_disk_{0};
  std::atomic<std::uint64_t> most_seen_points_{0};

  mutable Mutex mutex_;
  ConditionVariable changed_;
  std::deque<Task> tasks_ ULF_GUARDED_BY(mutex_);                // the first ones are being written
  std::deque<View> pictures_ ULF_GUARDED_BY(mutex_);             // on disk with their masters alone
  std::vector<int> pictures_being_made_ ULF_GUARDED_BY(mutex_);  // ids
  std::size_t views_waiting_ ULF_GUARDED_BY(mutex_) = 0;
  bool finishing_ ULF_GUARDED_BY(mutex_) = false;
  bool all_written_ ULF_GUARDED_BY(mutex_) = false;  // no more pictures will come
  bool behind_ ULF_GUARDED_BY(mutex_) = false;       // since the spool was full, until half of it is written
  std::optional<std::string> no_room_ ULF_GUARDED_BY(mutex_);  // the error of the full disk
  std::optional<std::string> failure_ ULF_GUARDED_BY(mutex_);
  std::size_t pictures_not_made_ ULF_GUARDED_BY(mutex_) = 0;
  std::size_t unwritten_ ULF_GUARDED_BY(mutex_) = 0;
  std::map<std::filesystem::path, std::size_t> set_aside_ ULF_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_;
};

}  // namespace ulf::coverage
