// Tests: commands/standard_streams.
#include <fcntl.h>
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <functional>
#include <iostream>
#include <string>

#include "commands/standard_streams.h"
#include "core/base/atomic_file.h"
#include "core/base/host_time.h"
#include "tests/support/test_paths.h"

namespace ulf::test::standard_streams_test {
namespace {

using commands::FlushStandardOutput;
using commands::GuardStandardStreams;

// Runs in a child process: first `before`, which lays descriptors, then the guard, then `work`. Returns its
// exit status, -1 where a signal ended it.
int Guarded(const std::function<void()>& before, const std::function<int()>& work) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGPIPE, SIG_DFL);
    before();
    GuardStandardStreams();
    int status = 99;
    try {
      status = work();
    } catch (...) {
    }
    _exit(status);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// By every way that the program and its libraries know.
void SayInEveryWay(int times) {
  for (int i = 0; i < times; ++i) {
    fmt::print(stderr, "fmt, {}\n", i);
    std::fprintf(stderr, "stdio, %d\n", i);
    std::fputc('\a', stderr);
    std::cerr << "iostreams, " << i << std::endl;
    fmt::print("report, {}\n", i);
    std::cout << "the same, " << i << '\n';
  }
}

void Lay(int descriptor, const std::string& file) {
  dup2(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644), descriptor);
}

TEST(StandardStreams, DeliverWhatIsPrinted) {
  const ScratchFolder scratch;
  const std::string file = scratch / "said";
  EXPECT_EQ(Guarded([&] { Lay(STDOUT_FILENO, file), dup2(STDOUT_FILENO, STDERR_FILENO); },
                    [] { return SayInEveryWay(1), FlushStandardOutput(); }),
            0);
  EXPECT_EQ(ReadWholeFile(file), "fmt, 0\nstdio, 0\n\aiostreams, 0\nreport, 0\nthe same, 0\n");
}

TEST(StandardStreams, FullOnesEndNothing) {
  const auto full = [](int descriptor) { return [descriptor] { Lay(descriptor, "/dev/full"); }; };
  const auto work = [] { return SayInEveryWay(10000), FlushStandardOutput(); };
  EXPECT_EQ(Guarded([&] { full(STDERR_FILENO)(), Lay(STDOUT_FILENO, "/dev/null"); }, work), 0);
  EXPECT_EQ(Guarded([&] { full(STDOUT_FILENO)(), Lay(STDERR_FILENO, "/dev/null"); }, work), ENOSPC);
}

TEST(StandardStreams, ReadersThatAreGoneEndNothing) {
  const auto before = [] {
    int ends[2];
    if (pipe(ends) != 0) _exit(98);
    dup2(ends[1], STDOUT_FILENO), dup2(ends[1], STDERR_FILENO);
    close(ends[0]), close(ends[1]);
  };
  EXPECT_EQ(Guarded(before, [] { return SayInEveryWay(10000), FlushStandardOutput(); }), EPIPE);
}

TEST(StandardStreams, ATerminalThatHungUpEndsNothing) {
  const auto before = [] {
    int master = -1, terminal = -1;
    if (openpty(&master, &terminal, nullptr, nullptr, nullptr) != 0) _exit(98);
    dup2(terminal, STDOUT_FILENO), dup2(terminal, STDERR_FILENO);
    close(terminal), close(master);
  };
  EXPECT_EQ(Guarded(before, [] { return SayInEveryWay(100), FlushStandardOutput(); }), EIO);
}

// A pipe to a program that is stopped, and a terminal behind a connection that does not answer.
TEST(StandardStreams, StalledReaderCostsASecond) {
  int pipe_ends[2], terminal_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  ASSERT_EQ(openpty(&terminal_ends[0], &terminal_ends[1], nullptr, nullptr, nullptr), 0);
  for (const auto& ends : {pipe_ends, terminal_ends}) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(Guarded([&] { dup2(ends[1], STDERR_FILENO), Lay(STDOUT_FILENO, "/dev/null"); },
                      [] { return SayInEveryWay(20000), FlushStandardOutput(); }),
              0);
    EXPECT_LT(SecondsSince(begin), 20);
    close(ends[0]), close(ends[1]);
  }
}

TEST(StandardStreams, ClosedDescriptorsAreFilled) {
  const ScratchFolder scratch;
  const std::string file = scratch / "journal";
  const auto work = [&] {
    const int opened = open(file.c_str(), O_WRONLY | O_CREAT, 0644);
    SayInEveryWay(3);
    char byte;
    if (opened <= STDERR_FILENO || read(STDIN_FILENO, &byte, 1) != 0) return 97;
    return FlushStandardOutput();
  };
  EXPECT_EQ(Guarded([] { close(STDIN_FILENO), close(STDOUT_FILENO), close(STDERR_FILENO); }, work), EBADF)
      << "a report that nobody gets is not written";
  EXPECT_EQ(
      Guarded([] { close(STDERR_FILENO), Lay(STDIN_FILENO, "/dev/null"), Lay(STDOUT_FILENO, "/dev/null"); },
              work),
      0);
  EXPECT_EQ(ReadWholeFile(file), "");
}

// Another program that shares standard output may have made it non-blocking.
TEST(StandardStreams, ASlowReaderGetsTheWholeReport) {
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_NONBLOCK), 0);
  const pid_t reader = fork();
  if (reader == 0) {
    close(ends[1]);
    fcntl(ends[0], F_SETFL, 0);
    std::string text;
    char bytes[4096];
    for (ssize_t count; (count = read(ends[0], bytes, sizeof bytes)) > 0; usleep(1000))
      text.append(bytes, static_cast<std::size_t>(count));
    _exit(text.size() == 300000 && text.ends_with("...x\n") ? 0 : 1);
  }
  close(ends[0]);
  EXPECT_EQ(Guarded([&] { dup2(ends[1], STDOUT_FILENO), close(ends[1]); },
                    [] {
                      fmt::print("{:.>299999}\n", "x");
                      return FlushStandardOutput();
                    }),
            0);
  close(ends[1]);
  int status = 0;
  waitpid(reader, &status, 0);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace ulf::test::standard_streams_test
