// What may reach the library that receives a GigE Vision stream. It believes what packets say of themselves:
// a number of packets is an allocation, a packet number a place in memory, and one forged packet ends the
// process. So the kernel looks at every packet first and lets through what the negotiated stream can hold:
//
//   from the camera's address, and from its port where the camera has told it (GevSCSP)
//   no longer than the negotiated packet size, and as long as its kind must be
//   leaders, payload and trailers of single images, with or without chunk data; numbers of packets within the
//   payload's; an image that fits the payload
//
// GVSP headers as in GigE Vision 2.x with 16-bit and with 64-bit frame numbers. A packet that may not pass
// goes to a second socket at the same port, which swallows and counts.
//
// Whoever can send from the camera's own address and port can still spoil frames, as a broken camera could:
// pixels, times and numbers of frames are not signed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace ulf::acquisition {

struct StreamBounds {
  std::string camera;   // IPv4 address
  int source_port = 0;  // 0: any
  std::size_t payload_bytes = 0;
  std::size_t packet_bytes = 0;  // as negotiated: with the headers of IP and UDP
};

class StreamGuard {
 public:
  // For a bound UDP socket. This object is to outlive it: without it packets pass unchecked. Throws Error
  // where the kernel does not do its part.
  StreamGuard(int socket, const StreamBounds& bounds);
  ~StreamGuard();
  StreamGuard(const StreamGuard&) = delete;
  StreamGuard& operator=(const StreamGuard&) = delete;

  std::uint64_t Refused() const;  // packets
  bool ChecksPort() const { return bounds_.source_port != 0; }
  // For a camera that told the wrong one.
  void AllowAnyPort();

 private:
  void Attach();

  StreamBounds bounds_;
  int swallower_ = -1;
};

}  // namespace ulf::acquisition
