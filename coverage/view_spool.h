// Recorded views on their way to disk: a bounded spool and the one thread that writes. When the spool is full
// the session does not wait; it does not record and says so. What the disk refuses ends the capture.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/frame.h"
#include "acquisition/frame_queue.h"
#include "acquisition/light_field_io.h"

namespace ulf {

class ViewSpool {
 public:
  // Without a thread every write happens inside the call.
  ViewSpool(LightFieldWriter writer, std::size_t capacity, bool threaded);
  ~ViewSpool();
  ViewSpool(const ViewSpool&) = delete;
  ViewSpool& operator=(const ViewSpool&) = delete;

  // False when there is no room.
  bool TryAddView(const Frame& frame, const View& view);
  // Poses of all views added so far, in order (those that were there at a resume first). False when there is
  // no room: try again later.
  bool TryUpdatePoses(std::vector<Rigid3> cam_from_world);
  void SetSubject(const Subject& subject);
  void NoteGap(double from_s, double to_s, const std::string& reason);

  // What the disk said no to, if it did.
  std::optional<std::string> Failure() const;
  // Writes what is left and hands the writer back.
  LightFieldWriter Finish();

 private:
  using Task = std::function<void(LightFieldWriter&)>;
  bool Submit(Task task, bool wait);
  void Run(const Task& task);
  void Loop();

  LightFieldWriter writer_;
  std::vector<int> view_ids_;                  // in order of adding; the writing thread's
  std::vector<Rigid3> journaled_;              // as the journal has them; the writing thread's
  std::unique_ptr<BoundedQueue<Task>> queue_;  // none without a thread
  mutable std::mutex mutex_;
  std::optional<std::string> failure_;
  std::thread thread_;
};

}  // namespace ulf
