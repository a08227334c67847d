// SIGINT and SIGTERM as a request to end in good order, for commands that run until told to stop.
#pragma once

namespace ulf {

// While one lives, the signals do nothing but make Asked() true. One at a time.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool Asked();
};

}  // namespace ulf
