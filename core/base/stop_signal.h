// Signals that ask a command to end in good order: SIGINT, SIGTERM, and the SIGHUP of a terminal that
// closes or of a connection that breaks.
#pragma once

#include <vector>

namespace ulf {

// Returns these signals, without SIGHUP if it was ignored from the start (nohup).
std::vector<int> StopSignals();

// While an object of this class exists, these signals only make Requested() true. At most one may exist.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool Requested();
};

// A separate stack for a thread's signal handlers lets the crash handler (commands/capture/crash_handler.h)
// run after a stack overflow. Each thread needs its own.

// Gives the calling thread such a stack until it ends. Does nothing if the thread has one.
void InstallSignalStack();

}  // namespace ulf
