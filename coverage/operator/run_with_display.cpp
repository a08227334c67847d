#include "coverage/operator/run_with_display.h"

#include <fmt/core.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include "acquisition/error.h"

namespace ulf {
namespace {

// The display's own clock: no faster than this, so that tracking keeps the processor.
constexpr double kFrameSeconds = 1.0 / 30;

void Show(Surface& surface, const DisplayOptions& options, CaptureFeed& feed, CaptureRequests& requests,
          const std::atomic<bool>& over) {
  using Clock = std::chrono::steady_clock;
  OperatorDisplay display(surface, feed, requests, options);
  auto next = Clock::now();
  while (!over) {
    if (!display.Step()) return;
    next = std::max(
        next + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kFrameSeconds)),
        Clock::now());
    std::this_thread::sleep_until(next);
  }
}

}  // namespace

void RunWithDisplay(const DisplayDoor& open, const DisplayOptions& options, CaptureFeed& feed,
                    CaptureRequests& requests, const std::function<void()>& capture) {
  std::unique_ptr<Surface> surface;
  try {
    if (open) surface = open();
  } catch (const Error& error) {
    fmt::print(stderr, "{}: capturing without the operator display, as with --headless\n", error.what());
  }
  if (!surface) {
    feed.Close();
    capture();
    return;
  }
  std::atomic<bool> over = false;
  std::exception_ptr thrown;
  std::thread session([&] {
    try {
      capture();
    } catch (...) {
      thrown = std::current_exception();
    }
    over = true;
  });
  try {
    Show(*surface, options, feed, requests, over);
  } catch (const std::exception& error) {
    // The capture is worth more than its picture.
    fmt::print(stderr, "the operator display is gone ({}); the capture goes on without it\n", error.what());
  }
  feed.Close();
  surface.reset();
  session.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace ulf
