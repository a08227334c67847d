#include "core/base/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace ulf {
namespace {

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Progress::Progress(std::string what, bool quiet)
    : what_(std::move(what)),
      quiet_(quiet),
      terminal_(isatty(fileno(stderr)) != 0),
      started_s_(SteadySeconds()) {}

Progress::~Progress() {
  if (!quiet_ && terminal_ && last_shown_s_ >= 0) std::fputc('\n', stderr);
}

void Progress::Say(const std::string& line) {
  fmt::print(stderr, "{}{}\n", terminal_ && last_shown_s_ >= 0 ? "\r\033[K" : "", line);
  std::fflush(stderr);
}

void Progress::Show(double share, const std::string& detail) {
  if (quiet_) return;
  const double now_s = SteadySeconds();
  if (now_s - started_s_ < 1.0) return;
  const double interval_s = terminal_ ? 0.1 : 2.0;
  const bool done = share >= 1 && last_share_ < 1;
  if (!done && last_shown_s_ >= 0 && now_s - last_shown_s_ < interval_s) return;
  last_shown_s_ = now_s;
  last_share_ = share;
  constexpr int kWidth = 24;
  const int filled = static_cast<int>(std::clamp(share, 0.0, 1.0) * kWidth);
  if (terminal_) {
    const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                            std::string(static_cast<std::size_t>(kWidth - filled), '.');
    fmt::print(stderr, "\r{:<12} [{}] {:3.0f} %  {}\033[K", what_, bar, 100 * share, detail);
  } else {
    fmt::print(stderr, "{}: {:.0f} % {}\n", what_, 100 * share, detail);
  }
  std::fflush(stderr);
}

}  // namespace ulf
