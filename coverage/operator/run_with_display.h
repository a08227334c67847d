// Runs a capture with its display: the capture in a thread of its own, the window in the caller's thread (the
// process's first, as windowing systems require).
#pragma once

#include <functional>
#include <memory>

#include "coverage/operator/operator_display.h"

namespace ulf::coverage {

using SurfaceFactory = std::function<std::unique_ptr<render::Surface>()>;

// Runs `capture`, which publishes to `feed` and obeys `requests`, to its end, and shows it on the surface
// that `open` returns; without `open` it is not shown. Closing the window, also by force, asks the capture to
// finish. Where no window can be opened (no display, no OpenGL), or it is gone, the capture goes on without
// one and begins to record if nobody has begun; a line on standard error says so. Rethrows what `capture`
// throws.
void RunWithDisplay(const SurfaceFactory& open, const DisplayOptions& options, CaptureFeed& feed,
                    CaptureRequests& requests, const std::function<void()>& capture);

}  // namespace ulf::coverage
