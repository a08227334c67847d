// SIGINT and SIGTERM as a request to end in good order, for commands that run until they are stopped.
#pragma once

namespace ulf {

// While an object of this class exists, these signals only make Asked() true. At most one may exist.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool Asked();
};

}  // namespace ulf
