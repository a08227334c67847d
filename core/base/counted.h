// Formats a number with its noun and a regular plural, "1 view" or "2 views", for texts that people read.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace ulf {

template <typename Number>
std::string Counted(Number count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace ulf
