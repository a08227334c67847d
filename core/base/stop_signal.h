// Signals that ask a command to end in good order: SIGINT, SIGTERM, and the SIGHUP of a terminal that
// closes or of a connection that breaks.
#pragma once

#include <vector>

namespace ulf {

// Returns these signals, without SIGHUP if it was ignored from the start (nohup).
std::vector<int> StopSignals();

// While an object of this class exists, at most one, these signals only make Requested() true.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool Requested();
};

// Gives the calling thread, until it ends, a separate stack for signal handlers, on which the crash handler
// (commands/capture/crash_handler.h) can run after a stack overflow. Does nothing if the thread has one.
void InstallSignalStack();

}  // namespace ulf
