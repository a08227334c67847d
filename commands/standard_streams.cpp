#include "commands/standard_streams.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#include <ext/stdio_sync_filebuf.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <iostream>

#include "core/base/stop_signal.h"

namespace ulf::commands {
namespace {

constexpr int kPatienceMs = 1000;  // until a reader of standard error counts as gone; guessed

int error_descriptor = STDERR_FILENO;
std::atomic<bool> error_stalled{false};
std::atomic<int> output_problem{0};

// Opens the pipe or terminal of standard error again, so that writing does not block; returns -1 if
// impossible. O_NONBLOCK on the descriptor itself would hold for all processes that share it.
int OpenErrorsWithoutBlocking() {
  struct stat about {};
  if (fstat(STDERR_FILENO, &about) != 0 || !(S_ISFIFO(about.st_mode) || isatty(STDERR_FILENO))) return -1;
  return open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
}

// Both always report that everything was written.
ssize_t WriteErrors(void*, const char* text, std::size_t size) {
  const int errno_before = errno;
  bool patient = !error_stalled;
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = write(error_descriptor, text + done, size - done);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
      error_stalled = false;
      patient = true;
    } else if (errno == EAGAIN) {
      pollfd room{error_descriptor, POLLOUT, 0};
      error_stalled = !patient || poll(&room, 1, kPatienceMs) <= 0;
      if (error_stalled) break;
      patient = false;
    } else if (errno != EINTR) {
      break;
    }
  }
  errno = errno_before;
  return static_cast<ssize_t>(size);
}

ssize_t WriteOutput(void*, const char* text, std::size_t size) {
  const int errno_before = errno;
  for (std::size_t done = 0; done < size && output_problem == 0;) {
    const ssize_t count = write(STDOUT_FILENO, text + done, size - done);
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
    } else if (errno == EAGAIN) {  // another process has made the shared descriptor non-blocking
      pollfd room{STDOUT_FILENO, POLLOUT, 0};
      poll(&room, 1, -1);
    } else if (errno != EINTR || StopOnSignal::Requested()) {  // nobody reads, and the user wants to stop
      output_problem = errno;
    }
  }
  errno = errno_before;
  return static_cast<ssize_t>(size);
}

}  // namespace

void FillStandardDescriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) >= 0) continue;
    // This takes the lowest free number, which is this one. A report to a closed standard output must fail.
    open("/dev/null", descriptor == STDOUT_FILENO ? O_RDONLY : O_RDWR);
  }
}

void GuardStandardStreams() {
  FillStandardDescriptors();
  signal(SIGPIPE, SIG_IGN);  // also for sockets: a lost camera becomes an error
  if (const int other = OpenErrorsWithoutBlocking(); other >= 0) error_descriptor = other;
  if (FILE* const errors = fopencookie(nullptr, "w", {nullptr, WriteErrors, nullptr, nullptr})) {
    setvbuf(errors, nullptr, _IONBF, 0);
    stderr = errors;
  }
  if (FILE* const output = fopencookie(nullptr, "w", {nullptr, WriteOutput, nullptr, nullptr})) {
    // The buffer has the size of a pipe's: a reader that leaves after the first line disturbs no shorter
    // report.
    static std::array<char, 1 << 16> buffer;
    setvbuf(output, buffer.data(), isatty(STDOUT_FILENO) ? _IOLBF : _IOFBF, buffer.size());
    stdout = output;
  }
  // They are used until the very end of the process.
  static auto* const output = new __gnu_cxx::stdio_sync_filebuf<char>(stdout);
  static auto* const errors = new __gnu_cxx::stdio_sync_filebuf<char>(stderr);
  std::cout.rdbuf(output);
  std::cerr.rdbuf(errors);
  std::clog.rdbuf(errors);
}

int FlushStandardOutput() {
  std::fflush(stdout);
  // Some network file systems report a failed write only when a descriptor is closed.
  if (const int copy = dup(STDOUT_FILENO); copy >= 0 && close(copy) != 0 && output_problem == 0)
    output_problem = errno;
  return output_problem;
}

}  // namespace ulf::commands
