// Filters the packets of a GigE Vision stream in the kernel (socket BPF) before Aravis receives them. Aravis
// trusts packet headers, so that one forged packet can end the process. The filter passes only packets that
// the negotiated stream can contain:
//
//   sender   the camera's address, and its port if the camera tells it (GevSCSP)
//   length   at most the negotiated packet size, and valid for the kind of packet
//   kind     leader, payload or trailer of a single image, with or without chunk data; packet numbers within
//            the payload; an image that fits the payload
//
// Headers follow GVSP (GigE Vision 2.x) with 16-bit and with 64-bit frame numbers. Other packets go to a
// second socket at the same port, which discards and counts them.
//
// A sender that uses the camera's own address and port can still corrupt frames: GVSP does not sign pixels,
// times or frame numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/file_descriptor.h"

namespace ulf::acquisition {

struct StreamBounds {
  std::string camera;   // IPv4 address
  int source_port = 0;  // 0: any
  std::size_t payload_bytes = 0;
  std::size_t packet_bytes = 0;  // as negotiated: with the headers of IP and UDP
};

class StreamGuard {
 public:
  // `socket`: the stream's bound UDP socket. This object must outlive the socket, because without it packets
  // pass unchecked. Throws Error if the kernel does not support the filter.
  StreamGuard(int socket, const StreamBounds& bounds);

  std::uint64_t Refused() const;  // packets
  bool ChecksPort() const { return bounds_.source_port != 0; }
  // Stops checking the sender's port, for a camera that sends from another port than it reported.
  void AllowAnyPort();

 private:
  void Attach();

  StreamBounds bounds_;
  FileDescriptor discard_socket_;
};

}  // namespace ulf::acquisition
