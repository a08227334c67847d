// Closes the light field when the process dies of a signal, for example because a camera library crashes or
// aborts. While a CrashHandler exists, such a signal replaces the process by `ulf close-after-death DIR ...`
// (exec: the same process number, fresh memory), which opens the light field again, closes it, reports that,
// and exits with 1. Data that were not on disk by then are lost, as with SIGKILL.
//
// A signal handler in a thread that has overrun its stack needs an alternate stack: this class gives one to
// the calling thread, core/base/stop_signal.h to those that capture or run the camera libraries' callbacks.
// In the libraries' other threads (Aravis's heartbeat, OpenCV's workers) an overrun still ends the process.
//
// It is disabled in builds with a sanitizer, which reports crashes itself. There is no core dump.
#pragma once

#include <filesystem>

#include "commands/options/command_line.h"

namespace ulf::commands {

// Handles the fatal signals of the process while it lives; at most one may exist at a time. `dir` is the
// light field's folder. The constructor throws Error if its path is too long (4096 bytes).
class CrashHandler {
 public:
  explicit CrashHandler(const std::filesystem::path& dir);
  ~CrashHandler();
  CrashHandler(const CrashHandler&) = delete;
  CrashHandler& operator=(const CrashHandler&) = delete;
};

// Adds `ulf close-after-death`, which the help does not show.
void AddCloseAfterCrashCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
