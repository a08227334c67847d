// Whether the address or the thread sanitizer is compiled in: then processes take several times the memory and time, and
// another allocator.
#pragma once

namespace ulf::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

// How many times as long a test waits for a program.
inline constexpr int kPatience = kIsSanitized ? 10 : 1;

}  // namespace ulf::test
