#include "tests/measure/gnuplot.h"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "tests/support/test_paths.h"

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

}  // namespace

std::string QuotedForGnuplot(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

void DrawChart(const std::string& path, int width, int height, const std::string& script) {
  const ScratchFolder scratch;
  const std::string file = (scratch / "script").string();
  std::ofstream(file) << fmt::format("set encoding utf8\nset terminal {}\n{}\nunset output\n",
                                     Terminal(EndingOf(path), width, height), script);
  const CommandResult finished = RunProgram("gnuplot", file);
  if (finished.exit_code == 127)
    throw Error("gnuplot cannot be started; install it: apt install gnuplot-nox");
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
