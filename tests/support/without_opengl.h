// A machine on which EGL finds no driver, for the programs that a test starts.
#pragma once

#include <cstdlib>

namespace ulf::test {

class WithoutOpenGl {
 public:
  WithoutOpenGl() { setenv(kDrivers, "/nowhere", 1); }
  ~WithoutOpenGl() { unsetenv(kDrivers); }
  WithoutOpenGl(const WithoutOpenGl&) = delete;
  WithoutOpenGl& operator=(const WithoutOpenGl&) = delete;

 private:
  static constexpr char kDrivers[] = "__EGL_VENDOR_LIBRARY_FILENAMES";
};

}  // namespace ulf::test
