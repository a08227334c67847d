// Who answers as a GigE Vision camera at an address, asked directly with one GVCP discovery packet: no
// library and no claim to control, so that a camera at work is not disturbed.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace ulf {

inline constexpr int kGvcpPort = 3956;

// The serial number of the camera at this IPv4 address; none when nothing answers in time.
std::optional<std::string> SerialOfGigeCamera(const std::string& address, std::chrono::milliseconds timeout);

}  // namespace ulf
