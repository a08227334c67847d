// What the test of a fault found, as a row of docs/reliability.md; `| grep '^|'` collects them.
#pragma once

#include <fmt/core.h>

#include <optional>
#include <string>

namespace ulf::test {

// `go_on_s`: from the end of the fault to the first view or picture after it; none: nothing had to begin anew.
inline void PrintFaultRow(const std::string& fault, int times, const std::string& lost,
                          const std::optional<double>& go_on_s) {
  fmt::print("| {} | {} | {} | {} |\n", fault, times, lost,
             go_on_s ? fmt::format("{:.2f} s", *go_on_s) : "at once");
}

}  // namespace ulf::test
