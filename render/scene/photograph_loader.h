// Reads photographs ahead of whoever draws them, in threads of its own.
#pragma once

#include <cstddef>
#include <exception>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "render/scene/photograph.h"

namespace ulf::render {

class PhotographLoader {
 public:
  // A level of a photograph, by any number that the caller knows it by.
  using Key = std::pair<int, int>;  // photograph, level
  struct Request {
    Key key;
    std::shared_ptr<const Photograph> photograph;
  };

  explicit PhotographLoader(int threads = 0);  // 0: one a processor
  ~PhotographLoader();                         // waits for what is being read
  PhotographLoader(const PhotographLoader&) = delete;
  PhotographLoader& operator=(const PhotographLoader&) = delete;

  // In order of urgency, in place of all that was asked for before: what was read and is not asked for any
  // more is dropped. So much of what nobody takes is read and, unless somebody waits, no more.
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;
  void Ask(std::vector<Request> requests);

  // Once read, and asked for no longer; none while it is not, and for what was not asked for. Throws what
  // reading it threw.
  std::optional<cv::Mat> Take(const Key& key);
  // Waits for it; of what was asked for.
  cv::Mat Wait(const Key& key);

 private:
  struct Read {
    cv::Mat pixels;
    std::exception_ptr problem;
  };
  void Run();
  std::optional<Request> Next();  // waits; none: it is over
  std::optional<cv::Mat> TakeLocked(const Key& key) ULF_REQUIRES(mutex_);

  Mutex mutex_;
  ConditionVariable work_, news_;
  std::vector<Request> waiting_ ULF_GUARDED_BY(mutex_);    // the most urgent last
  std::map<Key, bool> being_read_ ULF_GUARDED_BY(mutex_);  // whether anybody still wants it
  std::map<Key, Read> read_ ULF_GUARDED_BY(mutex_);
  std::size_t read_bytes_ ULF_GUARDED_BY(mutex_) = 0;
  int who_wait_ ULF_GUARDED_BY(mutex_) = 0;
  bool over_ ULF_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace ulf::render
