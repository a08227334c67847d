// One question to a GigE Vision camera without taking control of it: who controls it? Asked with the
// standard's own register read over UDP (GVCP READREG, control channel privilege at 0x0A00), because opening
// a camera to find out would take it away from its owner's next attempt and waits seconds when it is refused.
#pragma once

#include <chrono>
#include <string>

namespace ulf {

enum class GigeControl {
  kFree,
  kControlled,  // some program holds the control channel, perhaps this one
  kNoAnswer,    // not there, or not reachable by unicast from here
};

GigeControl AskGigeControl(const std::string& ipv4_address,
                           std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// True when the address is this computer's own, or more than one network could lead to the camera: there the
// packet socket of the streaming library may listen on the wrong one and hear nothing.
bool PacketSocketWouldMishear(const std::string& camera_ipv4_address);

}  // namespace ulf
