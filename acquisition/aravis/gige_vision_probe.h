// Questions to GigE Vision cameras over their control protocol (GVCP, UDP port 3956) without the library and
// without taking control: who is there, who controls it, is it reachable. Opening a camera to find out would
// take it away from its owner's next attempt and waits seconds when it is refused; a camera at work is not
// disturbed by these. Register addresses are those of the standard's bootstrap registers.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ulf::acquisition {

inline constexpr int kGvcpPort = 3956;

enum class GigeControl {
  kFree,
  kControlled,  // some program holds the control channel, perhaps this one
  kNoAnswer,    // not there, or not reachable by unicast from here
};
GigeControl AskGigeControl(const std::string& ipv4_address,
                           std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// One register, asked twice when the first question is not answered in time. None: no answer, or refused.
std::optional<std::uint32_t> ReadGigeRegister(
    const std::string& ipv4_address, std::uint32_t register_address,
    std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// Whose program controls the camera, where it says so (many leave both registers at zero): "192.0.2.5 (UDP
// port 40123)". Empty: it does not say.
std::string AskGigeController(const std::string& ipv4_address);

// What a camera says of itself in answer to a discovery packet.
struct GigeAnswer {
  std::string address, netmask;  // as the camera has them; the mask may be 0.0.0.0
  std::string maker = {}, model = {}, serial = {}, user_name = {};
};
// Asks one address directly; none when nothing answers in time.
std::optional<GigeAnswer> AskGigeCamera(const std::string& ipv4_address,
                                        std::chrono::milliseconds timeout = std::chrono::milliseconds(300));
// Asks by broadcast on every interface, and takes answers from cameras that have an address in another
// network.
std::vector<GigeAnswer> DiscoverGigeCameras(
    std::chrono::milliseconds timeout = std::chrono::milliseconds(400));

// An interface of this computer that is up, with its IPv4 network.
struct NetworkInterface {
  std::string name, address, netmask;
  bool loopback = false;
};
std::vector<NetworkInterface> NetworkInterfaces();

// Why `camera` cannot be reached from these interfaces: its address lies in none of their networks. Empty:
// that is not it.
std::string WrongNetworkText(const GigeAnswer& camera, const std::vector<NetworkInterface>& interfaces);

}  // namespace ulf::acquisition
