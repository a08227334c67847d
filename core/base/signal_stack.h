// A stack that a thread's signals are handled on, so that one who has overrun his own can still do something
// about it (commands/capture/crash_handler.h). The kernel keeps one for each thread, and a new thread has
// none.
#pragma once

namespace ulf {

// From the first call until the calling thread ends. A thread that has one already keeps it.
void HaveSignalStack();

}  // namespace ulf
