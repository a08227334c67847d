#include "core/base/waiting.h"

#include <fmt/format.h>

#include <utility>

#include "core/base/host_time.h"
#include "core/base/stop_signal.h"

namespace ulf {

Waiting::Waiting(std::string what, std::string step)
    : what_(std::move(what)), progress_(what_), step_(std::move(step)), thread_([this] { Loop(); }) {}

Waiting::~Waiting() {
  {
    const MutexLock lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Waiting::SetStep(std::string step) {
  const MutexLock lock(mutex_);
  step_ = std::move(step);
  since_ = std::chrono::steady_clock::now();
}

void Waiting::Loop() {
  InstallSignalStack();
  // Shorter work prints nothing. Guessed.
  std::chrono::milliseconds until_next(1000);
  MutexLock lock(mutex_);
  while (!changed_.wait_for(lock, until_next, [this]() ULF_REQUIRES(mutex_) { return over_; })) {
    progress_.Say(fmt::format("{}: {}, {:.0f} s so far", what_, step_, SecondsSince(since_)));
    until_next = std::chrono::milliseconds(3000);
  }
}

}  // namespace ulf
