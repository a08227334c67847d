// How many draws of chance a test looks at.
#pragma once

#include <cstdlib>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace ulf::test {

// The first one every day; with ULF_STABILITY=seeds, as in the long run (SEEDS of ulf_test), all of them.
inline std::vector<unsigned> SeedsOf(std::initializer_list<unsigned> all) {
  const char* asked = std::getenv("ULF_STABILITY");
  if (asked && std::string_view(asked) == "seeds") return all;
  return {*all.begin()};
}

}  // namespace ulf::test
