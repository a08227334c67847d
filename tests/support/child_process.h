// A program that a test starts beside itself, and that is gone when the test is.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace ulf::test {

// Times are kPatience times as long where a sanitizer slows programs (test_run.h).
class ChildProcess {
 public:
  // `command`: the program's path and its arguments. Throws Error when no process can be had.
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();  // kills it
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Returns its standard output since the last call, up to and with the first line that holds `text`, or what
  // came so far when it ends or the time is over.
  std::string ReadUntil(const std::string& text, double timeout_s);
  void Signal(int signal);
  // Waits for its end. Returns its exit code, or 128 + the signal that ended it; -1 when it still runs after
  // the time.
  int Wait(double timeout_s);
  void Kill();  // SIGKILL, and waits
  pid_t Pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int output_fd_ = -1;
  bool ended_ = false;
  int exit_code_ = -1;
};

}  // namespace ulf::test
