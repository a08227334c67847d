// A separate stack for a thread's signal handlers, so that the crash handler
// (commands/capture/crash_handler.h) can run after a stack overflow. Each thread needs its own.
#pragma once

namespace ulf {

// Gives the calling thread such a stack until it ends. Does nothing where the thread has one.
void InstallSignalStack();

}  // namespace ulf
