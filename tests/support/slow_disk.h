// A disk that takes its time, refuses, or is the last thing that a process asked. Everything else about it is
// real: the calls of the whole program that change files go through here first, by the linker's --wrap, in
// the tests that link ulf_slow_disk.
#pragma once

#include <chrono>

namespace ulf::test {

// From the constructor to the destructor, for regular files and folders; one at a time. All that are being
// waited for end with it.
class SlowDisk {
 public:
  struct Speed {
    std::chrono::milliseconds
        a_wait;  // each fsync(); four times as long where a sanitizer slows what waits for it
    double bytes_per_s;
  };
  explicit SlowDisk(const Speed& speed);
  ~SlowDisk();
  SlowDisk(const SlowDisk&) = delete;
  SlowDisk& operator=(const SlowDisk&) = delete;
};

// A disk that does not answer at all, until the end or for twenty seconds (eighty under a sanitizer): then
// all that wait for it are let go.
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

// A disk that refuses every write() and fsync() with this errno.
class RefusingDisk {
 public:
  explicit RefusingDisk(int error);
  ~RefusingDisk();
  RefusingDisk(const RefusingDisk&) = delete;
  RefusingDisk& operator=(const RefusingDisk&) = delete;
};

// This process dies of SIGKILL before its `call`-th call of write(), fsync(), ftruncate(), rename(),
// renameat2(), link() or unlink() from here on, of a regular file or folder. For a child of a test.
void DieBeforeDiskCall(int call);
// Calls until then.
int DiskCallsLeft();

}  // namespace ulf::test
