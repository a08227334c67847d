#include "core/base/other_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr int kAskToStop_ms = 100;
constexpr int kSignalled = 128;   // as shells say it
constexpr int kNotStarted = 127;  // as shells say it

// Kills the program unless it has been waited for.
class Child {
 public:
  explicit Child(pid_t process) : process_(process) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (process_ < 0) return;
    kill(process_, SIGKILL);
    Wait();
  }
  int Wait() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return WIFSIGNALED(status) ? kSignalled + WTERMSIG(status) : WEXITSTATUS(status);
  }

 private:
  pid_t process_;
};

// Runs in the child, where other threads may have held locks: it makes system calls alone.
[[noreturn]] void BecomeProgram(const char* program, char* const* words, int output, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kNotStarted);
  signal(SIGPIPE, SIG_DFL);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  dup2(nothing, STDIN_FILENO);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) dup2(output, stream);
  execv(program, words);
  _exit(kNotStarted);
}

// Splits what arrives into lines.
class Lines {
 public:
  explicit Lines(const std::function<void(const std::string&)>& take) : take_(take) {}
  void Add(const char* bytes, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      if (bytes[i] == '\n' || bytes[i] == '\r')
        End();
      else
        line_ += bytes[i];
  }
  void End() {
    if (!line_.empty()) take_(line_);
    line_.clear();
  }

 private:
  const std::function<void(const std::string&)>& take_;
  std::string line_;
};

}  // namespace

fs::path ProgramInPath(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder) / name;
    std::error_code unknown;
    if (fs::is_regular_file(file, unknown) && access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

ProgramEnd RunOtherProgram(const fs::path& program, const std::vector<std::string>& arguments,
                           const std::function<void(const std::string&)>& take_line,
                           const std::function<bool()>& stop) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    throw Error("{}: cannot be started: {}", program.string(), std::strerror(errno));
  const FileDescriptor output(ends[0]);
  FileDescriptor input(ends[1]);
  std::string name = program.string();
  std::vector<std::string> texts = arguments;
  std::vector<char*> words{name.data()};
  for (std::string& text : texts) words.push_back(text.data());
  words.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t process = fork();
  if (process < 0) throw Error("{}: cannot be started: {}", name, std::strerror(errno));
  if (process == 0) BecomeProgram(name.c_str(), words.data(), input.Number(), parent);
  Child child(process);
  input = FileDescriptor();
  Lines lines(take_line);
  while (true) {
    if (stop()) return {.status = kSignalled + SIGKILL, .stopped = true};
    pollfd waiting{output.Number(), POLLIN, 0};
    if (poll(&waiting, 1, kAskToStop_ms) <= 0) continue;
    std::array<char, 4096> bytes;
    const ssize_t count = read(output.Number(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    lines.Add(bytes.data(), static_cast<std::size_t>(count));
  }
  lines.End();
  const int status = child.Wait();
  return {.status = status, .stopped = stop()};
}

}  // namespace ulf
