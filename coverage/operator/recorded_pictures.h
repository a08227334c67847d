// Keeps small pictures of the recorded views, as many as fit into a memory budget. The newest view's picture
// comes with the capture's state; others (of an earlier session, or dropped from memory) are read from the
// light field when they are needed. Ids and poses always come from the newest state.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/light_field/light_field.h"
#include "coverage/operator/posed_pictures.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

// Reads small copies of recorded views from the light field, the first wanted first, in a thread of its own
// while the capture goes on writing. It writes nothing.
class StoredPictures {
 public:
  explicit StoredPictures(const std::filesystem::path& light_field);
  ~StoredPictures();  // waits for the picture that is being read
  StoredPictures(const StoredPictures&) = delete;
  StoredPictures& operator=(const StoredPictures&) = delete;

  // Replaces the list of wanted views; returns how many of them have not been taken yet. A view that is not
  // on disk yet is looked for again.
  std::size_t Want(std::vector<int> ids);
  // Returns what has been read since the last call, by view id; poses are the journal's.
  std::map<int, PosedPicture> Take();
  // Returns why a picture cannot be read, once each; such a picture is not tried again. Returns none when
  // there is no new problem.
  std::optional<std::string> TakeProblem();

 private:
  using Clock = std::chrono::steady_clock;
  void Loop();
  void Read(const View& view);
  void ReadJournal();
  const View* Find(int id) const;
  void Say(const std::string& problem);

  // The thread's own.
  LightField on_disk_;
  Clock::time_point journal_due_;
  bool said_journal_ = false;

  Mutex mutex_;
  ConditionVariable changed_;
  std::vector<int> wanted_ ULF_GUARDED_BY(mutex_);
  std::map<int, PosedPicture> read_ ULF_GUARDED_BY(mutex_);
  std::set<int> unreadable_ ULF_GUARDED_BY(mutex_);
  std::vector<std::string> problems_ ULF_GUARDED_BY(mutex_);
  bool over_ ULF_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

class RecordedPictures {
 public:
  // `most_bytes`: guessed; it holds some six hundred pictures of a scene rich in detail, as many as most
  // captures have.
  explicit RecordedPictures(std::size_t most_bytes = 64 << 20) : most_bytes_(most_bytes) {}

  // Call it for every picture of the display: keeps the newest view's picture, takes what was read, drops
  // pictures of views that were taken back, and goes over to the lens in use.
  void Follow(const CaptureState& state);
  // Returns up to three pictures nearest in direction to a camera, as seen from the subject, with weights
  // that fall towards 0 at the first one left out. Pictures that are not in memory are skipped, and fetched
  // for a later call. The result is valid until the next call of any function.
  std::vector<WeightedPicture> Nearest(const CaptureState& state, const Rigid3& cam_from_world);
  // Returns how many pictures of the last Nearest() are still being read.
  std::size_t missing() const { return missing_; }
  std::size_t bytes() const { return bytes_; }
  std::size_t size() const { return held_.size(); }
  // Returns why a picture is left out, once each.
  std::optional<std::string> TakeProblem();

 private:
  struct Held {
    PosedPicture picture;
    std::uint64_t used = 0;  // the last time, by clock_
  };
  void Hold(int id, PosedPicture picture);
  void ConvertToLens(PosedPicture& picture) const;
  void MakeRoom();

  const std::size_t most_bytes_;
  std::map<int, Held> held_;
  std::size_t bytes_ = 0, missing_ = 0;
  std::uint64_t clock_ = 0;
  int newest_ = 0;                          // that was kept
  std::optional<CameraModel> lens_;         // CaptureState::recorded_camera
  std::vector<CameraModel> former_lenses_;  // before it
  std::unique_ptr<StoredPictures> stored_;
};

}  // namespace ulf::coverage
