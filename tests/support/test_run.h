// Tells a test how it is run (under a sanitizer or not, with how many seeds), hides OpenGL, and prints
// rows of a table.
#pragma once

#include <fmt/core.h>

#include <cstdlib>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ulf::test {

// Whether the address or the thread sanitizer is compiled in: then processes take several times the memory
// and time, and use another allocator.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

// How many times as long as usual a test waits for a program.
inline constexpr int kPatience = kIsSanitized ? 10 : 1;

// Returns the first seed in an everyday run, all of them in a long one (ULF_STABILITY=seeds, as SEEDS of
// ulf_test() sets it).
inline std::vector<unsigned> SeedsOf(std::initializer_list<unsigned> all) {
  const char* asked = std::getenv("ULF_STABILITY");
  if (asked && std::string_view(asked) == "seeds") return all;
  return {*all.begin()};
}

// While it lives, EGL finds no driver in the programs that the test starts.
class WithoutOpenGl {
 public:
  WithoutOpenGl() { setenv(kDrivers, "/nowhere", 1); }
  ~WithoutOpenGl() { unsetenv(kDrivers); }
  WithoutOpenGl(const WithoutOpenGl&) = delete;
  WithoutOpenGl& operator=(const WithoutOpenGl&) = delete;

 private:
  static constexpr char kDrivers[] = "__EGL_VENDOR_LIBRARY_FILENAMES";
};

// Prints what the test of a fault found, as a row of docs/measured/cameras.md; `| grep '^|'` collects
// the rows. `go_on_s`: from the end of the fault to the first view or picture after it; none: nothing
// had to begin anew.
inline void PrintFaultRow(const std::string& fault, int times, const std::string& lost,
                          const std::optional<double>& go_on_s) {
  fmt::print("| {} | {} | {} | {} |\n", fault, times, lost,
             go_on_s ? fmt::format("{:.2f} s", *go_on_s) : "at once");
}

}  // namespace ulf::test
