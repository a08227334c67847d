// The addresses that simulated GigE Vision cameras stand at. The protocol knows one UDP port, so that every
// camera needs an IPv4 address of its own; on the loopback interface there are enough of them.
#pragma once

#include <string>

namespace ulf::acquisition {

// Throws UsageError for what is no IPv4 address, Error when another camera or program has this one's port, or
// when it is not this machine's.
void RequireFreeGigeAddress(const std::string& address);

// An address of the loopback network (127.x.x.x) that the interface answers for as long as this object lives.
// One that was there before stays, unless a killed simulator has left it behind: what nobody claims any more
// is taken over, and all other such addresses are removed. Other addresses are left alone.
class LoopbackAddress {
 public:
  // Throws Error, with the command to run, when it is missing and may not be added.
  explicit LoopbackAddress(const std::string& address);
  ~LoopbackAddress();
  LoopbackAddress(const LoopbackAddress&) = delete;
  LoopbackAddress& operator=(const LoopbackAddress&) = delete;

 private:
  std::string label_;  // of what was added; empty: nothing was
  int claim_ = -1;     // that a process which is gone does not hold
};

// Where a camera hides when a relay stands at `address` in its place: 127.a.b.c to 127.(a+64).b.c. Throws
// UsageError for an address outside 127.0.0.0/10.
std::string HiddenGigeAddress(const std::string& address);

}  // namespace ulf::acquisition
