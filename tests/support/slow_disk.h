// A disk that takes its time. Everything else about it is real: write() and fsync() of the whole program go
// through here first, by the linker's --wrap, in the tests that link ulf_slow_disk.
#pragma once

#include <chrono>

namespace ulf::test {

// From the constructor to the destructor, for regular files and folders; one at a time. All that are being
// waited for end with it.
class SlowDisk {
 public:
  struct Speed {
    std::chrono::milliseconds a_wait;  // each fsync()
    double bytes_per_s;
  };
  explicit SlowDisk(const Speed& speed);
  ~SlowDisk();
  SlowDisk(const SlowDisk&) = delete;
  SlowDisk& operator=(const SlowDisk&) = delete;
};

// A disk that does not answer at all, until the end or for twenty seconds: then all that wait for it are let
// go.
class HangingDisk {
 public:
  HangingDisk();
  ~HangingDisk();
  HangingDisk(const HangingDisk&) = delete;
  HangingDisk& operator=(const HangingDisk&) = delete;
  // Whether somebody waits for it.
  bool SomebodyWaits() const;
  bool GaveUp() const;  // somebody waited for so long

 private:
  SlowDisk disk_;
};

}  // namespace ulf::test
