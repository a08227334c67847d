// A light field that gets closed even when the process dies of a signal: a camera library that runs into
// memory which is not there, or aborts, takes everything down with it. While one of these lives, such a
// signal turns the process into `ulf close-after-death DIR ...` (the same process by its number, with nothing
// left of what failed), which opens the light field anew, closes it, says so, and exits with 1. What had not
// reached the disk by then is lost, as it is with SIGKILL.
//
// A thread that has overrun its stack needs another one for that: the calling thread has it here, those that
// capture and that run the camera libraries' callbacks by core/base/signal_stack.h. In the libraries' other
// threads (Aravis's heartbeat, OpenCV's workers) an overrun ends the process as ever.
//
// Not in builds with a sanitizer, which has its own word to say then. There is no core dump.
#pragma once

#include <filesystem>

#include "commands/command_line.h"

namespace ulf::commands {

// One at a time.
class CrashHandler {
 public:
  explicit CrashHandler(const std::filesystem::path& dir);
  ~CrashHandler();
  CrashHandler(const CrashHandler&) = delete;
  CrashHandler& operator=(const CrashHandler&) = delete;
};

// Not shown in the help.
void AddCloseAfterCrashCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
