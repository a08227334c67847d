// Simulates a faulty network link: a relay between a GigE Vision camera and its client. The client uses the
// relay's address as the camera's; the camera has another address of this machine. The relay forwards control
// (GVCP) both ways, rewrites the stream's destination, and loses, doubles, swaps or delays its packets.
//
// The relay keeps the packets of the last frames and answers PACKETRESEND for the camera (bit 2 of the
// capability register at 0x0934): it resends lost packets over the same faulty link.
//
// Seed, frame number and packet number decide which packets are affected, so that faults do not depend on
// time. A late frame delays all packets after it, as on a congested link.
//
// All functions may be called from any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "acquisition/simulator/simulated_faults.h"

namespace ulf::acquisition {

struct GigeRelayOptions {
  std::string camera;   // the camera's address
  std::string address;  // the relay's address, which clients use
  GigeLinkFaults faults;
  bool resends = true;
  std::uint64_t seed = 7;
};

struct GigeRelayStatistics {
  std::uint64_t frames = 0, packets = 0;  // from the camera
  std::uint64_t lost = 0, doubled = 0, swapped = 0;
  std::uint64_t late_frames = 0;
  std::uint64_t resend_requests = 0, resent = 0;
};

class GigeRelay {
 public:
  // The relay runs when the constructor returns. Throws Error when an address cannot be used.
  explicit GigeRelay(const GigeRelayOptions& options);
  ~GigeRelay();
  GigeRelay(const GigeRelay&) = delete;
  GigeRelay& operator=(const GigeRelay&) = delete;

  // Lets a channel pass or discards its packets without an answer, as a pulled cable does.
  void PassControl(bool passes);
  void PassStream(bool passes);
  void Pull();     // neither passes
  void PutBack();  // both pass

  GigeRelayStatistics Statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
