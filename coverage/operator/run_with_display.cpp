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

void RunWithDisplay(const std::function<std::unique_ptr<Surface>()>& open, const DisplayOptions& options,
                    CaptureFeed& feed, CaptureRequests& requests, const std::function<void()>& capture,
                    const std::function<void(const std::string&)>& say) {
  std::unique_ptr<Surface> surface;
  try {
    surface = open();
  } catch (const Error& error) {
    say(fmt::format("{}: capturing without the operator display, as with --headless", error.what()));
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
    say(fmt::format("the operator display is gone ({}); the capture goes on without it", error.what()));
  }
  surface.reset();
  session.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace ulf
