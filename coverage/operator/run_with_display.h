// A capture with its display: the capture in a thread of its own, the window in the caller's (the process's
// first, as windowing systems ask).
#pragma once

#include <functional>
#include <memory>

#include "coverage/operator/operator_display.h"

namespace ulf {

// Runs `capture`, which publishes to `feed` and obeys `requests`, to its end and shows it meanwhile. Closing
// the window asks it to finish. Where `open` throws Error (no display, no OpenGL) the capture goes on
// without, and that is said. What `capture` throws comes out here.
void RunWithDisplay(const std::function<std::unique_ptr<Surface>()>& open, const DisplayOptions& options,
                    CaptureFeed& feed, CaptureRequests& requests, const std::function<void()>& capture,
                    const std::function<void(const std::string&)>& say);

}  // namespace ulf
