// The doors by which files and lines of others come in, each as a function of bytes: for the fuzzer, which looks for
// bytes that break one, and for the everyday test, which reads the corpus again.
//
// A door may throw Error and nothing else, takes no more memory than kMostMemory for the small files that a fuzzer makes,
// and what it returns is finite and names no file outside its folder. What breaks that ends the process.
#pragma once

#include <span>
#include <string_view>

namespace ulf::test {

struct FuzzTarget {
  const char* name;
  void (*read)(std::string_view bytes);
};

std::span<const FuzzTarget> FuzzTargets();
// Null: there is none of that name.
const FuzzTarget* FuzzTargetByName(std::string_view name);

}  // namespace ulf::test
