// A capture with its display: the capture in a thread of its own, the window in the caller's (the process's
// first, as windowing systems ask).
#pragma once

#include <functional>
#include <memory>

#include "coverage/operator/operator_display.h"

namespace ulf::coverage {

using DisplayDoor = std::function<std::unique_ptr<render::Surface>()>;

// Runs `capture`, which publishes to `feed` and obeys `requests`, to its end, and shows it meanwhile on what
// `open` gives; without `open` it is not shown. Closing the window, also by force, asks the capture to
// finish. Where there is no window to be had (no display, no OpenGL) the capture goes on without, and
// standard error says so. What `capture` throws comes out here.
void RunWithDisplay(const DisplayDoor& open, const DisplayOptions& options, CaptureFeed& feed,
                    CaptureRequests& requests, const std::function<void()>& capture);

}  // namespace ulf::coverage
