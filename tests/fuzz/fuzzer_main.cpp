// The program for libFuzzer: `ULF_FUZZ_TARGET=journal ulf_fuzzer NEW CORPUS` (./run fuzz starts it). New
// inputs go into the folder NEW, which should not be in the tree; findings beside the temporary files unless
// -artifact_prefix says where. Either may bring down libraries of others.
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "tests/fuzz/fuzz_targets.h"

namespace {

const ulf::test::FuzzTarget* chosen = nullptr;

// libFuzzer would write findings into the folder in which it was started.
void KeepFindingsOutsideTheTree(int* argc, char*** argv) {
  static std::vector<char*> arguments(*argv, *argv + *argc);
  if (std::ranges::any_of(arguments, [](std::string_view a) { return a.starts_with("-artifact_prefix="); }))
    return;
  static std::string prefix =
      "-artifact_prefix=" + (std::filesystem::temp_directory_path() / "ulf_fuzz-").string();
  arguments.push_back(prefix.data());
  *argc += 1;
  arguments.push_back(nullptr);
  *argv = arguments.data();
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  spdlog::set_level(spdlog::level::off);
  KeepFindingsOutsideTheTree(argc, argv);
  const char* const name = std::getenv("ULF_FUZZ_TARGET");
  chosen = name == nullptr ? nullptr : ulf::test::FuzzTargetByName(name);
  if (chosen != nullptr) return 0;
  fmt::print(stderr, "ULF_FUZZ_TARGET must be one of");
  for (const auto& target : ulf::test::FuzzTargets()) fmt::print(stderr, " {}", target.name);
  fmt::print(stderr, "\n");
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    chosen->read({reinterpret_cast<const char*>(data), size});
  } catch (const ulf::Error&) {
  }
  return 0;
}
