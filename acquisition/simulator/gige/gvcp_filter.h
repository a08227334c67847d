// Filters the control requests (GVCP, GigE Vision 2.x) that reach the simulated camera. Aravis's camera side
// trusts packet headers, so that one request can end the process. The filter therefore owns the network
// sockets, and forwards valid requests to Aravis through a pair of connected sockets. It answers all other
// requests itself, with the protocol's status codes:
//
//   NOT_IMPLEMENTED    an unknown command, or several registers in one request
//   INVALID_HEADER     a length that differs from the packet's
//   INVALID_PARAMETER  a count of zero or of more than an answer holds, a value out of the register's range
//   INVALID_ADDRESS    an address beyond registers and description
//   BAD_ALIGNMENT      an address that is not a multiple of four
//   WRITE_PROTECT      a read-only register
//   ACCESS_DENIED      a write by a client without control of the camera, except the request for control
//                      while no other client has it
//
// It ignores packets that are no GVCP requests, and invalid requests that want no answer or arrive by
// broadcast.
//
// Requests are handled one at a time, as in Aravis; while Aravis renders a frame they wait.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace ulf::acquisition {

// A register of four bytes at `address` that accepts values for which `takes` is true.
struct WritableRegister {
  std::uint32_t address;
  std::function<bool(std::uint32_t)> takes;
};

// A register that a valid request reads or writes; `written`: its new value.
struct GvcpAccess {
  std::uint32_t address = 0;
  std::optional<std::uint32_t> written;
};

struct GvcpFilterOptions {
  int unicast = -1;                // bound to the camera's address and port 3956
  std::vector<int> broadcasts;     // for discovery only
  int camera = -1;                 // connected to Aravis
  std::uint32_t memory_bytes = 0;  // registers, then the description
  std::vector<WritableRegister> writable;
  std::function<std::uint32_t()>
      privilege;  // control channel privilege at this moment; 0: nobody controls the camera
  std::function<void(const GvcpAccess&)> before = {};  // called before Aravis gets the request
};

class GvcpFilter {
 public:
  // Takes ownership of the sockets.
  explicit GvcpFilter(GvcpFilterOptions options);
  ~GvcpFilter();
  GvcpFilter(const GvcpFilter&) = delete;
  GvcpFilter& operator=(const GvcpFilter&) = delete;

  std::uint64_t Refused() const;  // requests that were not forwarded

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
