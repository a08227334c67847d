#include "core/base/stop_signal.h"

#include <signal.h>
#include <atomic>
#include <cstddef>
#include <map>
#include <memory>

namespace ulf {

namespace {

std::atomic<bool> stop_asked{false};
std::map<int, struct sigaction> actions_before;  // former actions of the signals

constexpr std::size_t kBytes = 1 << 16;  // the crash handler needs a few KiB; guessed

class SignalStack {
 public:
  SignalStack() {
    stack_t before{};
    if (sigaltstack(nullptr, &before) != 0 || (before.ss_flags & SS_DISABLE) == 0) return;
    memory_ = std::make_unique_for_overwrite<std::byte[]>(kBytes);
    stack_t ours{};
    ours.ss_sp = memory_.get();
    ours.ss_size = kBytes;
    if (sigaltstack(&ours, nullptr) != 0) memory_.reset();
  }
  ~SignalStack() {
    if (!memory_) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    sigaltstack(&none, nullptr);
  }
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<std::byte[]> memory_;
};

}  // namespace

std::vector<int> StopSignals() {
  struct sigaction hangup {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler == SIG_IGN) return {SIGINT, SIGTERM};
  return {SIGINT, SIGTERM, SIGHUP};
}

StopOnSignal::StopOnSignal() {
  stop_asked = false;
  struct sigaction action {};
  action.sa_handler = [](int) { stop_asked = true; };
  for (const int signal : StopSignals()) sigaction(signal, &action, &actions_before[signal]);
}

StopOnSignal::~StopOnSignal() {
  for (const auto& [signal, action] : actions_before) sigaction(signal, &action, nullptr);
  actions_before.clear();
}

bool StopOnSignal::Requested() { return stop_asked; }

void InstallSignalStack() { static thread_local const SignalStack stack; }

}  // namespace ulf
