// Recorded views on their way to disk: a bounded spool, threads that encode, and one that writes.
//
// What was taken is written, whatever the disk does, in the order in which it was taken. While it is behind
// (the spool is full) or full (no room for what waits and for closing), nothing more is taken, and Pause()
// says why; what the disk refused is tried again until there is room. Room is looked at before a view is
// taken, so that all that was taken normally fits. Anything else that the disk says no to (permissions, a
// folder that is gone) is a Failure(): no view is recorded after it, and what was taken all the same is set
// aside, in unposed/ or else beside the light field. What finds no place there either is counted:
// Unwritten().
//
// Views that wait together go to the disk together (LightFieldWriter::AddViews). A view with a master is
// recorded when the master and its journal line are on disk: that is as fast as the disk. Its photograph in
// images/ takes the processor ten times as long and follows, made from the master by threads that give way to
// everything else; Finish() waits for them. One that cannot be made is told and holds nothing up: like those
// that a kill leaves out, it is made by the next to open the light field.
//
// A killed process loses the views that had not reached the disk: those being written together, eight at
// most, and those that wait behind them, which are few while the disk keeps up and never more than the
// capacity but for photographs.
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
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/image/frame.h"
#include "core/light_field/light_field_io.h"

namespace ulf::coverage {

// Why no view is taken at the moment.
struct SpoolPause {
  bool disk_is_full = false;  // else it is slow: views wait to be written
  std::string words;          // for people
};

class ViewSpool {
 public:
  // Without threads every write happens inside the call, photographs included.
  ViewSpool(LightFieldWriter writer, std::size_t capacity, bool threaded);
  ~ViewSpool();
  ViewSpool(const ViewSpool&) = delete;
  ViewSpool& operator=(const ViewSpool&) = delete;

  // The id that the view will have on disk; none when there is no room.
  std::optional<int> TryAddView(const Frame& frame, const View& view);
  // Taken although there is no room, to be written when there is: photographs come seldom and are never given
  // up. Before one is asked for, Pause() is.
  int AddView(const Frame& frame, const View& view);
  void KeepUnposed(const Frame& frame);
  // A view that was added shows so many points: room is kept for what the files say of them in the end.
  void ExpectSeenPoints(std::size_t points) {
    most_seen_points_ = std::max<std::uint64_t>(most_seen_points_, points);
  }
  // A view that was added, on disk or still waiting: it is written first, so that its photograph is never
  // lost, and then moves to unposed/.
  void RemoveView(int id);
  // Poses by view id, as many as have changed or more. False when there is no room: try again later.
  bool TryUpdatePoses(std::map<int, Rigid3> cam_from_world);
  void SetSubject(const Subject& subject);
  void NoteGap(double from_s, double to_s, const std::string& reason);

  // None: views are taken.
  std::optional<SpoolPause> Pause();
  // What the disk said no to for good, if it did.
  std::optional<std::string> Failure() const;
  // Not yet recorded.
  std::size_t ViewsWaiting() const;
  // Photographs that are to follow their masters.
  std::size_t PicturesWaiting() const;
  // Writes what is left, without waiting for room, and hands the writer back. Failure() then says what did
  // not fit; a photograph that did not is made when the light field is next opened.
  LightFieldWriter Finish();
  // What a view of this frame takes on disk, at most.
  static std::uint64_t MostBytes(const Frame& frame);
  // After Finish(). Frames that were taken and are nowhere on disk.
  std::size_t Unwritten() const;
  // The same. Frames that were to be recorded, or kept in unposed/, and are elsewhere, by folder.
  std::map<std::filesystem::path, std::size_t> SetAside() const;

 private:
  struct PendingView {
    LightFieldWriter::NewView view;
    enum { kWaiting, kBeingEncoded, kEncoded } state = kWaiting;  // under mutex_
    std::exception_ptr problem;                                   // of encoding
  };
  // A line, a view, or a frame for unposed/.
  struct Task {
    std::function<void(LightFieldWriter&)> write_line;
    std::shared_ptr<PendingView> view;
    std::optional<Frame> unposed;
    bool IsFrame() const { return view || unposed; }
  };
  enum class Outcome { kWritten, kNoRoom, kFailed };
  Task Adding(const Frame& frame, const View& view);
  bool Submit(Task task, bool only_if_room);
  bool WriteHere(bool only_if_room);
  Outcome Write(std::span<const Task> tasks);
  void WriteViews(std::span<const Task> tasks);
  Outcome Try(const std::function<void()>& write, std::string& problem);
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world);
  void Remove(int id);
  bool Rescue(const Task& task);
  void Done(bool written) ULF_REQUIRES(mutex_);
  void Loop();
  void EncodeLoop();
  void PictureLoop();
  std::size_t NextTogether(std::size_t most_views) const ULF_REQUIRES(mutex_);
  std::uint64_t NeededBytes(std::uint64_t views) const ULF_REQUIRES(mutex_);

  LightFieldWriter writer_;
  const std::filesystem::path root_;
  const std::size_t capacity_;
  const bool threaded_;
  int next_id_ = 0;                  // of views that are added; the adding thread's
  std::map<int, Rigid3> journaled_;  // poses by id, as the journal has them; the writing thread's
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
  std::optional<std::string> no_room_ ULF_GUARDED_BY(mutex_);  // what the disk said when it was full
  std::optional<std::string> failure_ ULF_GUARDED_BY(mutex_);
  std::size_t pictures_not_made_ ULF_GUARDED_BY(mutex_) = 0;
  std::size_t unwritten_ ULF_GUARDED_BY(mutex_) = 0;
  std::map<std::filesystem::path, std::size_t> set_aside_ ULF_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_;
};

}  // namespace ulf::coverage
