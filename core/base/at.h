// Converts an int index, as files and triangles keep it, to the index type of containers.
#pragma once

#include <cstddef>

namespace ulf {

constexpr std::size_t At(int index) { return static_cast<std::size_t>(index); }

}  // namespace ulf
