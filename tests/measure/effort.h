// Says how much is measured, and on which seeds, for charts and stability curves alike.
#pragma once

#include <vector>

namespace ulf::test {

// Thresholds, and what counts as right, were settled on seeds below this one (most on 1 to 20, on the
// simulator's usual scene and on the recordings whose chart says so). Reported results use seeds from it on.
inline constexpr unsigned kFirstSeed = 101;

struct Effort {
  bool quick = false;  // fewer seeds and values: shows that it works, and its figures say little
  // Returns the first of two numbers, or lists, when quick, else the second.
  template <typename T>
  T Of(T quickly, T fully) const {
    return quick ? quickly : fully;
  }
  // Returns the first `count` seeds that are reported; one when quick.
  std::vector<unsigned> Seeds(unsigned count) const {
    std::vector<unsigned> seeds;
    for (unsigned i = 0; i < Of(1u, count); ++i) seeds.push_back(kFirstSeed + i);
    return seeds;
  }
};

}  // namespace ulf::test
