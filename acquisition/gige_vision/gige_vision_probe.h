// Queries GigE Vision cameras by their control protocol (GVCP, UDP port 3956), without Aravis and without
// taking control: which cameras exist, who controls them, whether they are reachable. Opening a camera for
// that would block other programs, and takes seconds if the camera refuses.
#pragma once

#include <netinet/in.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ulf::acquisition {

inline constexpr int kGvcpPort = 3956;

// Returns an IPv4 address in host byte order; none if the text is no address.
std::optional<std::uint32_t> Ipv4(const std::string& text);
sockaddr_in SocketAddress(std::uint32_t ipv4, int port);

enum class GigeControl {
  kFree,
  kControlled,  // a program, perhaps this one, controls the camera
  kNoAnswer,    // no camera has this address, or it is not reachable by unicast from here
};
GigeControl QueryGigeControl(const std::string& ipv4_address,
                             std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// Reads one register (gvcp.h), and asks once more if no answer comes within the timeout. Returns none if the
// camera does not answer or refuses.
std::optional<std::uint32_t> ReadGigeRegister(
    const std::string& ipv4_address, std::uint32_t register_address,
    std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// Returns the address of the program that controls the camera, "192.0.2.5 (UDP port 40123)"; empty if the
// camera does not tell it (many leave both registers at zero).
std::string QueryGigeController(const std::string& ipv4_address);

// A camera's answer to a discovery packet.
struct GigeAnswer {
  std::string address, netmask;  // as the camera has them; the mask may be 0.0.0.0
  std::string maker = {}, model = {}, serial = {};
};
// Returns none for a packet that is no whole answer to a discovery packet.
std::optional<GigeAnswer> ReadGigeAnswer(std::span<const std::uint8_t> packet);
// Sends a discovery packet to one address. Returns none if nothing answers within the timeout.
std::optional<GigeAnswer> QueryGigeCamera(const std::string& ipv4_address,
                                          std::chrono::milliseconds timeout = std::chrono::milliseconds(300));
// Broadcasts discovery packets on every interface and returns all answers within the timeout, also of cameras
// whose address belongs to another network.
std::vector<GigeAnswer> DiscoverGigeCameras(
    std::chrono::milliseconds timeout = std::chrono::milliseconds(400));

// An interface of this computer that is up, with its IPv4 network.
struct NetworkInterface {
  std::string name, address, netmask;
  bool loopback = false;
};
std::vector<NetworkInterface> NetworkInterfaces();

// Returns a message if the camera's address is in the network of none of the interfaces, else an empty text.
std::string WrongNetworkText(const GigeAnswer& camera, const std::vector<NetworkInterface>& interfaces);

}  // namespace ulf::acquisition
