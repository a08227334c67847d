// Takes the control sockets of Aravis's camera, so that requests reach it only through the filter
// (gvcp_filter.h). Aravis continues with other sockets under the same descriptor numbers (dup3): one that is
// connected to the filter, and unconnected ones for discovery. It keeps its stream socket.
#pragma once

#include <string>
#include <vector>

#include "acquisition/gige_vision/bound_sockets.h"

namespace ulf::acquisition {

struct TakenSockets {
  int unicast = -1;  // bound to the camera's address; -1: there was none
  std::vector<int> broadcasts;
  int to_library = -1;  // Aravis receives what is sent here
  int stream_port = 0;  // source port of Aravis's stream packets; 0: not found
  int stream = -1;      // another descriptor of the socket that they come from
};

// Takes the sockets that were opened since `before` for a camera at `address`. Throws Error when the system
// has no more sockets.
TakenSockets TakeControlSockets(const std::vector<BoundSocket>& before, const std::string& address);

}  // namespace ulf::acquisition
