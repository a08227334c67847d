#include "core/base/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "core/base/host_time.h"

namespace ulf {
namespace {

constexpr double kQuietAtFirstS = 1.0;                           // shorter work shows nothing; guessed
constexpr double kTerminalIntervalS = 0.1, kLogIntervalS = 2.0;  // least time between two lines; guessed
constexpr int kBarWidth = 24;                                    // characters

}  // namespace

Progress::Progress(std::string what, bool quiet)
    : what_(std::move(what)), quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (!quiet_ && terminal_ && last_shown_s_ >= 0) std::fputc('\n', stderr);
}

void Progress::Say(const std::string& line) {
  fmt::print(stderr, "{}{}\n", terminal_ && last_shown_s_ >= 0 ? "\r\033[K" : "", line);
  std::fflush(stderr);
}

void Progress::Show(double share, const std::string& detail) {
  if (quiet_) return;
  const double now_s = SecondsSince(started_);
  if (now_s < kQuietAtFirstS) return;
  const double interval_s = terminal_ ? kTerminalIntervalS : kLogIntervalS;
  const bool done = share >= 1 && last_share_ < 1;
  if (!done && last_shown_s_ >= 0 && now_s - last_shown_s_ < interval_s) return;
  last_shown_s_ = now_s;
  last_share_ = share;
  if (terminal_) {
    std::string bar(kBarWidth, '.');
    std::fill_n(bar.begin(), static_cast<int>(std::clamp(share, 0.0, 1.0) * kBarWidth), '#');
    fmt::print(stderr, "\r{:<12} [{}] {:3.0f} %  {}\033[K", what_, bar, 100 * share, detail);
  } else {
    fmt::print(stderr, "{}: {:.0f} % {}\n", what_, 100 * share, detail);
  }
  std::fflush(stderr);
}

}  // namespace ulf
