// The control side of the simulated camera, as the network meets it. The library's own believes what a packet
// says of itself (one READREG beyond its registers ends the process), so it hears nothing from the network:
// the door has its sockets, and passes on to it, through a pair of connected sockets that nobody else can
// reach, the requests that it answers well. All others are answered here, with the protocol's status codes:
//
//   NOT_IMPLEMENTED    a command that the camera has not, several registers in one request
//   INVALID_HEADER     a length that is not the packet's
//   INVALID_PARAMETER  a count of nothing or of more than fits an answer, a value out of the register's range
//   INVALID_ADDRESS    beyond registers and description
//   BAD_ALIGNMENT      not a multiple of four
//   WRITE_PROTECT      a register that is not to be written
//   ACCESS_DENIED      writing, without control of the camera, anything but the request for it, and that
//   while
//                      another client has it
//
// What does not begin as a request of the protocol gets no answer, nor does a wrong one that asks for none,
// or that came by broadcast.
//
// One request at a time, as in the library; while it renders a frame, the next ones wait.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace ulf::acquisition {

// May be written, four bytes at `address`, with a value for which `takes` is true.
struct WritableRegister {
  std::uint32_t address;
  std::function<bool(std::uint32_t)> takes;
};

struct GvcpFilterOptions {
  int unicast = -1;                // bound to the camera's address and port 3956
  std::vector<int> broadcasts;     // for discovery only
  int camera = -1;                 // connected to the library's camera
  std::uint32_t memory_bytes = 0;  // registers and, behind them, the description
  std::vector<WritableRegister> writable;
  std::function<std::uint32_t()> privilege;  // of the control channel, now; 0: nobody controls the camera
};

class GvcpFilter {
 public:
  // Takes over the sockets.
  explicit GvcpFilter(GvcpFilterOptions options);
  ~GvcpFilter();
  GvcpFilter(const GvcpFilter&) = delete;
  GvcpFilter& operator=(const GvcpFilter&) = delete;

  std::uint64_t Refused() const;  // requests that were not passed on

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
