// The program for libFuzzer: `ULF_FUZZ_TARGET=journal ulf_fuzzer CORPUS` (./run fuzz starts it).
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "core/base/error.h"
#include "tests/fuzz/fuzz_targets.h"

namespace {

const ulf::test::FuzzTarget* chosen = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  spdlog::set_level(spdlog::level::off);
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
