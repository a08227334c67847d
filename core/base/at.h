// An index as containers want it. Files and triangles keep indices as int.
#pragma once

#include <cstddef>

namespace ulf {

constexpr std::size_t At(int index) { return static_cast<std::size_t>(index); }

}  // namespace ulf
