// Defines what usbfs_preload.cpp and an emulated USB node (usb_node.h) say to each other, over one socket for
// each open file: one Reply for each Request, each followed by as many bytes as it says.
#pragma once

#include <sys/socket.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>

namespace ulf::test::usbfs {

// The variable that names the folder of the nodes' sockets: "002-003" stands for /dev/bus/usb/002/003.
inline constexpr char kFolderVariable[] = "ULF_TEST_USBFS";

// The first Reply comes unasked, and where its error is 0 it brings the file that the program gets.
struct Request {
  std::uint32_t number = 0;    // of the ioctl
  std::uint32_t bytes = 0;     // that follow
  std::uint64_t argument = 0;  // its value, or the address of the caller's usbdevfs_urb
};

// Follows a request of USBDEVFS_SUBMITURB; behind it the data of a transfer to the device.
struct Urb {
  std::uint8_t type = 0, endpoint = 0;
  std::uint16_t unused = 0;
  std::uint32_t flags = 0;
  std::int32_t length = 0;
};

struct Reply {
  std::int32_t result = 0, error = 0;
  std::uint64_t urb = 0;                 // that is reaped
  std::int32_t status = 0, actual = 0;   // of it
  std::uint32_t bytes = 0, into_at = 0;  // that follow, for the caller's memory from there
};

// Both return false where the other side is gone.
inline bool SendAll(int socket, const void* data, std::size_t bytes) {
  const char* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t sent = send(socket, from, bytes, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    from += sent;
    bytes -= static_cast<std::size_t>(sent);
  }
  return true;
}

inline bool ReceiveAll(int socket, void* data, std::size_t bytes) {
  char* to = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = recv(socket, to, bytes, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace ulf::test::usbfs
