#include "coverage/operator/run_with_display.h"

#include <fmt/core.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include "core/base/error.h"
#include "core/base/stop_signal.h"

namespace ulf::coverage {
namespace {

using Clock = std::chrono::steady_clock;

// Guessed: the least time between pictures (more pictures take the processor from tracking), and how long the
// final state stays.
constexpr auto kPicture =
    std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / 30));
constexpr std::chrono::seconds kFinalState(3);

// Nobody is there who could begin.
void BeginWithoutDisplay(CaptureRequests& requests) {
  requests.Push(SetRecording{.on = true, .although_checks_fail = true});
}

// Returns false once the person has closed it.
bool ShowWhile(const std::function<bool()>& goes_on, OperatorDisplay& display) {
  auto next = Clock::now();
  while (goes_on()) {
    if (!display.Step()) return false;
    next = std::max(next + kPicture, Clock::now());
    std::this_thread::sleep_until(next);
  }
  return true;
}

void Show(std::unique_ptr<render::Surface> surface, const DisplayOptions& options, CaptureFeed& feed,
          CaptureRequests& requests, const std::atomic<bool>& over) {
  std::unique_ptr<OperatorDisplay> display;
  const auto continue_without = [&](const char* problem) {
    if (!display) BeginWithoutDisplay(requests);
    const bool records = !display || display->Detach();
    fmt::print(stderr, "the operator display is gone ({}); the capture goes on without it{}\n", problem,
               records ? "" : "; recording stays paused, as was asked: Ctrl-C closes the light field");
  };
  try {
    display = std::make_unique<OperatorDisplay>(*surface, feed, requests, options);
    if (!ShowWhile([&] { return !over; }, *display) || !display->ShowFinalState()) return;
    const auto until = Clock::now() + kFinalState;
    ShowWhile([&] { return Clock::now() < until; }, *display);
  } catch (const render::SurfaceKilled& killed) {
    fmt::print(stderr, "{}: the capture finishes\n", killed.what());
    requests.Push(FinishCapture{});
    render::Abandon(std::move(display));
    render::Abandon(std::move(surface));
  } catch (const render::SurfaceGone& gone) {
    continue_without(gone.what());
    render::Abandon(std::move(display));
    render::Abandon(std::move(surface));
  } catch (const std::exception& error) {
    continue_without(error.what());
  }
}

}  // namespace

void RunWithDisplay(const SurfaceFactory& open, const DisplayOptions& options, CaptureFeed& feed,
                    CaptureRequests& requests, const std::function<void()>& capture) {
  std::unique_ptr<render::Surface> surface;
  try {
    if (open) surface = open();
  } catch (const Error& error) {
    fmt::print(stderr, "{}: capturing without the operator display, as with {}\n", error.what(),
               Parameter("headless"));
    BeginWithoutDisplay(requests);
  }
  if (!surface) {
    feed.Close();
    capture();
    return;
  }
  std::atomic<bool> over = false;
  std::exception_ptr thrown;
  std::thread session([&] {
    InstallSignalStack();
    try {
      capture();
    } catch (...) {
      thrown = std::current_exception();
    }
    over = true;
  });
  Show(std::move(surface), options, feed, requests, over);
  feed.Close();
  session.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace ulf::coverage
