#include "core/base/available_memory.h"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace ulf {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

std::optional<std::uint64_t> ReadNumber(const char* path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  return file >> value ? std::optional(value) : std::nullopt;
}

std::uint64_t LeftOnMachine() {
  std::ifstream file("/proc/meminfo");
  std::string key;
  std::uint64_t kilobytes = 0;
  for (std::string unit; file >> key >> kilobytes; std::getline(file, unit))
    if (key == "MemAvailable:") return 1024 * kilobytes;
  return kNoLimit;
}

std::uint64_t LeftInControlGroup() {
  const auto most = ReadNumber("/sys/fs/cgroup/memory.max"),
             used = ReadNumber("/sys/fs/cgroup/memory.current");
  if (!most || !used) return kNoLimit;
  return *most > *used ? *most - *used : 0;
}

std::uint64_t LeftToProcess() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  const std::uint64_t used =
      ReadNumber("/proc/self/statm").value_or(0) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur > used ? limit.rlim_cur - used : 0;
}

}  // namespace

std::uint64_t AvailableMemory() { return std::min({LeftOnMachine(), LeftInControlGroup(), LeftToProcess()}); }

void ShareHeaps() {
  constexpr int kHeaps = 2;
  if (!std::getenv("MALLOC_ARENA_MAX")) mallopt(M_ARENA_MAX, kHeaps);
}

}  // namespace ulf
