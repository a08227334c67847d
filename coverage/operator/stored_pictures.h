// Reads small copies of recorded views from the light field, in a thread of its own while the capture goes on
// writing; the most wanted first. Reads the journal and the photographs and writes nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/light_field/light_field.h"
#include "coverage/operator/posed_pictures.h"

namespace ulf::coverage {

class StoredPictures {
 public:
  explicit StoredPictures(const std::filesystem::path& light_field);
  ~StoredPictures();  // waits for the picture that is being read
  StoredPictures(const StoredPictures&) = delete;
  StoredPictures& operator=(const StoredPictures&) = delete;

  // Replaces the list of wanted views; returns how many of them are still to be read. A view that is not on
  // disk yet is looked for again.
  std::size_t Want(std::vector<int> ids);
  // What has been read since the last call, by view id; poses are the journal's.
  std::map<int, PosedPicture> Take();
  // Why a picture cannot be read: once for each, and it is not tried again. None: nothing new.
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

}  // namespace ulf::coverage
