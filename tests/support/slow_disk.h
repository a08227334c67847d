// Makes the disk slow, refusing, or deadly for the process that uses it. Everything else about it is real: in
// the tests that link ulf_slow_disk, all calls of the program that change files go through here first, by the
// linker's --wrap.
#pragma once

#include <chrono>

namespace ulf::test {

// Slows writes to regular files and folders from the constructor to the destructor; one object at a time. The
// destructor lets go all calls that wait.
class SlowDisk {
 public:
  struct Speed {
    std::chrono::milliseconds a_wait;  // of each fsync(); kPatience times as long (test_run.h)
    double bytes_per_s;
  };
  explicit SlowDisk(const Speed& speed);
  ~SlowDisk();
  SlowDisk(const SlowDisk&) = delete;
  SlowDisk& operator=(const SlowDisk&) = delete;
};

// A disk that does not answer at all, until the destructor or for 20 s (200 s under a sanitizer): then all
// that wait for it are let go.
class HangingDisk {
 public:
  HangingDisk();
  ~HangingDisk();
  HangingDisk(const HangingDisk&) = delete;
  HangingDisk& operator=(const HangingDisk&) = delete;
  bool SomebodyWaits() const;
  bool GaveUp() const;  // returns whether somebody waited for so long

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

// Lets this process die of SIGKILL before its `call`-th call of write() or fsync() to a regular file or
// folder, ftruncate(), rename(), renameat2(), link() or unlink() from here on. For a child of a test.
void DieBeforeDiskCall(int call);
int DiskCallsLeft();  // until then; 0: it is not to die

}  // namespace ulf::test
