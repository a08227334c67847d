#include "tests/support/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "core/base/error.h"
#include "tests/support/test_run.h"

namespace ulf::test {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw Error("no pipe to a child process");
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that crashes leaves nothing running
    dup2(ends[1], STDOUT_FILENO);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  output_fd_ = ends[0];
  if (pid_ < 0) throw Error("{}: cannot be started", command[0]);
}

ChildProcess::~ChildProcess() {
  Kill();
  close(output_fd_);
}

std::string ChildProcess::ReadUntil(const std::string& text, double timeout_s) {
  timeout_s *= kPatience;
  const auto start = Clock::now();
  std::string output;
  while (output.find(text) == std::string::npos || output.back() != '\n') {
    const double left_s = timeout_s - SecondsSince(start);
    pollfd waiting{output_fd_, POLLIN, 0};
    if (left_s <= 0 || poll(&waiting, 1, static_cast<int>(1e3 * left_s) + 1) <= 0) break;
    char c;
    if (read(output_fd_, &c, 1) != 1) break;
    output += c;
  }
  return output;
}

void ChildProcess::Signal(int signal) {
  if (!ended_) kill(pid_, signal);
}

int ChildProcess::Wait(double timeout_s) {
  timeout_s *= kPatience;
  const auto start = Clock::now();
  while (!ended_) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) {
      ended_ = true;
      exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    } else if (SecondsSince(start) > timeout_s) {
      return -1;
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  return exit_code_;
}

void ChildProcess::Kill() {
  Signal(SIGCONT);
  Signal(SIGKILL);
  Wait(60);  // a disk that others fill holds it back
}

}  // namespace ulf::test
