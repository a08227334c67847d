#include "core/base/stop_signal.h"

#include <signal.h>

#include <atomic>
#include <map>

namespace ulf {
namespace {

std::atomic<bool> stop_asked{false};
std::map<int, struct sigaction> actions_before;  // what each of the signals did before

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

bool StopOnSignal::Asked() { return stop_asked; }

}  // namespace ulf
