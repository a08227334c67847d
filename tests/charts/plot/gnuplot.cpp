#include "tests/charts/plot/gnuplot.h"

#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"

extern char** environ;

namespace ulf::test {
namespace {

std::string EndingOf(const std::string& path) {
  return Lowercase(std::filesystem::path(path).extension().string());
}

std::string Terminal(const std::string& ending, int width, int height) {
  constexpr const char* kFont = "DejaVu Sans,11";
  if (ending == ".svg")
    return fmt::format("svg size {},{} font '{}' background 'white'", width, height, kFont);
  if (ending == ".pdf")
    return fmt::format("pdfcairo size {}in,{}in font '{}'", width / 100.0, height / 100.0, kFont);
  return fmt::format("pngcairo size {},{} font '{}' background 'white'", width, height, kFont);
}

using File = std::unique_ptr<FILE, int (*)(FILE*)>;

File TemporaryFile() {
  File file(std::tmpfile(), std::fclose);
  if (!file)
    throw Error("gnuplot: no temporary file ({}); check that {} is writable and has room",
                std::strerror(errno), P_tmpdir);
  return file;
}

std::string Contents(FILE* file) {
  std::rewind(file);
  std::string text;
  char buffer[4096];
  while (const std::size_t read = std::fread(buffer, 1, sizeof buffer, file)) text.append(buffer, read);
  return text;
}

struct Finished {
  int exit_code = -1;
  std::string output, errors;
};

Finished RunGnuplot(const std::string& script) {
  const File input = TemporaryFile(), output = TemporaryFile(), errors = TemporaryFile();
  if (std::fwrite(script.data(), 1, script.size(), input.get()) != script.size() || std::fflush(input.get()))
    throw Error("gnuplot: its script cannot be written ({}); make room in {}", std::strerror(errno),
                P_tmpdir);
  // The child shares the file's position.
  lseek(fileno(input.get()), 0, SEEK_SET);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(input.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(output.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(errors.get()), STDERR_FILENO);
  char name[] = "gnuplot";
  // From a named file it stops at the first error; from its standard input it would go on.
  char from[] = "/dev/stdin";
  char* arguments[] = {name, from, nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, name, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    throw Error("gnuplot cannot be started ({}); install it: apt install gnuplot-nox", std::strerror(failed));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, Contents(output.get()), Contents(errors.get())};
}

}  // namespace

std::string QuotedForGnuplot(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

void DrawChart(const std::string& path, int width, int height, const std::string& script) {
  const std::string setup =
      fmt::format("set encoding utf8\nset terminal {}\n", Terminal(EndingOf(path), width, height));
  const Finished finished = RunGnuplot(setup + script + "\nunset output\n");
  if (finished.exit_code == 0 && !finished.output.empty()) {
    WriteFileAtomically(path, finished.output);
    return;
  }
  // The last line with a line number, else the first one: gnuplot repeats the command with a caret before it.
  std::istringstream lines(finished.errors);
  std::string line, message;
  while (std::getline(lines, line))
    if (line.find("line ") != std::string::npos || message.empty()) message = line;
  throw Error("{}: gnuplot could not draw it: {}", path,
              message.empty() ? fmt::format("it ended with status {}", finished.exit_code) : message);
}

}  // namespace ulf::test
