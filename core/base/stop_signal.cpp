#include "core/base/stop_signal.h"

#include <signal.h>

#include <atomic>

namespace ulf {
namespace {

std::atomic<bool> stop_asked{false};
struct sigaction before_int, before_term;

}  // namespace

StopOnSignal::StopOnSignal() {
  stop_asked = false;
  struct sigaction action {};
  action.sa_handler = [](int) { stop_asked = true; };
  sigaction(SIGINT, &action, &before_int);
  sigaction(SIGTERM, &action, &before_term);
}

StopOnSignal::~StopOnSignal() {
  sigaction(SIGINT, &before_int, nullptr);
  sigaction(SIGTERM, &before_term, nullptr);
}

bool StopOnSignal::Asked() { return stop_asked; }

}  // namespace ulf
