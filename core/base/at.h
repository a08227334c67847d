// Indices are ints where they stand in files and triangles; containers want theirs.
#pragma once

#include <cstddef>

namespace ulf {

constexpr std::size_t At(int index) { return static_cast<std::size_t>(index); }

}  // namespace ulf
