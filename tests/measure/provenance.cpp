#include "tests/measure/provenance.h"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

// The first line of what git says in the checkout.
std::string Git(const std::string& arguments) {
  const std::string said = RunProgram("git", "-C '" CHECKOUT "' " + arguments).output;
  return said.substr(0, said.find('\n'));
}

std::string Processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace

std::string Provenance(const std::string& command) {
  const std::string commit = Git("rev-parse --short HEAD");
  const std::string changed =
      commit.empty() ? "no commit is known" : Git("status --porcelain -- . ':!docs' ':!*.md'");
  if (!changed.empty() && !std::getenv(kMeasureChanged))
    throw Error("{} could not be made again: the tree differs from its commit ({}); commit, or set {}=1",
                command, changed, kMeasureChanged);
  return fmt::format("{1}{0}{2} of {3}{0}{4:%Y-%m-%d}{0}{5}{6}", kBetween, command,
                     std::thread::hardware_concurrency(), Processor(), fmt::gmtime(std::time(nullptr)),
                     commit, changed.empty() ? "" : "+");
}

std::string WithoutCommand(const std::string& provenance) {
  const std::size_t end = provenance.find(kBetween);
  return end == std::string::npos ? "" : provenance.substr(end + kBetween.size());
}

void ReplacePart(const std::string& page, const std::string& name, const std::string& text) {
  const std::string begin = fmt::format("<!-- {} -->", name), end = fmt::format("<!-- /{} -->", name);
  std::string whole = std::filesystem::exists(page) ? ReadWholeFile(page) : "";
  const std::string part = begin + "\n" + text + end;
  const std::size_t from = whole.find(begin), to = whole.find(end);
  if (from != std::string::npos && to != std::string::npos)
    whole.replace(from, to + end.size() - from, part);
  else
    whole += "\n" + part + "\n";
  WriteFileAtomically(page, whole);
}

}  // namespace ulf::test
