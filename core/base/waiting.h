// Says on standard error what a person is waiting for while work runs that cannot tell its share, such as the
// end of a capture. After the first second a thread of its own prints a line every three seconds, with the
// step and the seconds that it has taken so far.
#pragma once

#include <chrono>
#include <string>
#include <thread>

#include "core/base/mutex.h"
#include "core/base/progress.h"

namespace ulf {

class Waiting {
 public:
  // Starts the thread, which ends with the object; `what` such as "closing", `step` as "depth maps".
  Waiting(std::string what, std::string step);
  ~Waiting();
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
  // Announces that the next step begins.
  void SetStep(std::string step);

 private:
  void Loop();

  const std::string what_;
  Progress progress_;  // used by the thread alone
  Mutex mutex_;
  ConditionVariable changed_;
  std::string step_ ULF_GUARDED_BY(mutex_);
  std::chrono::steady_clock::time_point since_ ULF_GUARDED_BY(mutex_) = std::chrono::steady_clock::now();
  bool over_ ULF_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace ulf
