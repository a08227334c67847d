// Queries GigE Vision cameras by their control protocol (GVCP, UDP port 3956), without the library and
// without taking control: which cameras exist, who controls them, whether they are reachable. Opening a
// camera for that would block other programs, and waits seconds when it is refused. Register addresses are
// those of the standard's bootstrap registers.
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

// An IPv4 address in host order; none where the text is not one.
std::optional<std::uint32_t> Ipv4(const std::string& text);
sockaddr_in SocketAddress(std::uint32_t ipv4, int port);

enum class GigeControl {
  kFree,
  kControlled,  // a program holds the control channel, perhaps this one
  kNoAnswer,    // no camera there, or not reachable by unicast from here
};
GigeControl QueryGigeControl(const std::string& ipv4_address,
                             std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// Reads one register, a second time when there is no answer within the timeout. Returns none when there is no
// answer, or the camera refuses.
std::optional<std::uint32_t> ReadGigeRegister(
    const std::string& ipv4_address, std::uint32_t register_address,
    std::chrono::milliseconds timeout = std::chrono::milliseconds(300));

// Returns the address of the program that controls the camera, "192.0.2.5 (UDP port 40123)". It is empty
// where the camera does not tell (many leave both registers at zero).
std::string QueryGigeController(const std::string& ipv4_address);

// A camera's answer to a discovery packet.
struct GigeAnswer {
  std::string address, netmask;  // as the camera has them; the mask may be 0.0.0.0
  std::string maker = {}, model = {}, serial = {};
};
// Returns none when it is no whole answer to a discovery packet.
std::optional<GigeAnswer> ReadGigeAnswer(std::span<const std::uint8_t> packet);
// Sends a discovery packet to one address; none when nothing answers within the timeout.
std::optional<GigeAnswer> QueryGigeCamera(const std::string& ipv4_address,
                                          std::chrono::milliseconds timeout = std::chrono::milliseconds(300));
// Sends discovery packets by broadcast on every interface; also finds cameras whose address belongs to
// another network.
std::vector<GigeAnswer> DiscoverGigeCameras(
    std::chrono::milliseconds timeout = std::chrono::milliseconds(400));

// An interface of this computer that is up, with its IPv4 network.
struct NetworkInterface {
  std::string name, address, netmask;
  bool loopback = false;
};
std::vector<NetworkInterface> NetworkInterfaces();

// Returns a message where the camera's address is in the network of none of these interfaces, else empty.
std::string WrongNetworkText(const GigeAnswer& camera, const std::vector<NetworkInterface>& interfaces);

}  // namespace ulf::acquisition
