// Takes the control sockets of the library's camera away from it, so that the network reaches it through the
// door alone (gvcp_filter.h). The library goes on with others of the same numbers: one that is connected to
// the door, and for discovery ones that nothing ever comes to. Its stream socket stays its own.
#pragma once

#include <string>
#include <vector>

#include "acquisition/aravis/bound_sockets.h"

namespace ulf::acquisition {

struct TakenSockets {
  int unicast = -1;  // bound to the camera's address; -1: the library had none
  std::vector<int> broadcasts;
  int to_library = -1;  // what is sent here the library receives
  int stream_port = 0;  // that the library's packets come from; 0: not found
};

// Of what the library has opened since `before`, for a camera at `address`. Throws Error when the system has
// no more sockets.
TakenSockets TakeControlSockets(const std::vector<BoundSocket>& before, const std::string& address);

}  // namespace ulf::acquisition
