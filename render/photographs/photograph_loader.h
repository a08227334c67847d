// Reads levels of photographs in its own threads, before the renderer needs them. One thread uses it.
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
#include "render/photographs/photograph.h"

namespace ulf::render {

class PhotographLoader {
 public:
  using Key = std::pair<int, int>;  // the photograph's number, which the caller chooses, and the level
  struct Request {
    Key key;
    std::shared_ptr<const Photograph> photograph;
  };

  explicit PhotographLoader(int threads = 0);  // 0: one for each processor
  ~PhotographLoader();                         // waits for the reads in progress

  // Replaces all earlier requests by these, the most urgent first. Levels that were read and are not among
  // them are dropped.
  void SetRequests(std::vector<Request> requests);
  // Once this many bytes were read and not taken, the loader continues only during Wait(). Guessed.
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;

  // Returns the level if it was requested and is read; the request is then done. Throws what reading threw.
  std::optional<cv::Mat> Take(const Key& key);
  // Does the same but waits. A level that was not requested never comes.
  cv::Mat Wait(const Key& key);

 private:
  struct Read {
    cv::Mat pixels;
    std::exception_ptr problem;
  };
  void Run();
  std::optional<Request> Next();  // waits; none: the loader is being destroyed
  std::optional<cv::Mat> TakeLocked(const Key& key) ULF_REQUIRES(mutex_);

  Mutex mutex_;
  ConditionVariable work_, news_;
  std::vector<Request> waiting_ ULF_GUARDED_BY(mutex_);    // most urgent last
  std::map<Key, bool> being_read_ ULF_GUARDED_BY(mutex_);  // value: still requested
  std::map<Key, Read> read_ ULF_GUARDED_BY(mutex_);
  std::size_t read_bytes_ ULF_GUARDED_BY(mutex_) = 0;
  int waiters_ ULF_GUARDED_BY(mutex_) = 0;
  bool over_ ULF_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace ulf::render
