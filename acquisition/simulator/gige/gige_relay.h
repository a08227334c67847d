// A bad cable that can be asked for: a man in the middle of a GigE Vision camera and its client. The client
// talks to the relay's address as if it were the camera's; the camera stands at another address of this
// machine. Control (GVCP) passes both ways, the stream's destination is rewritten, and stream packets (GVSP)
// can be lost, doubled, swapped or held back on their way.
//
// The relay keeps the packets of the last frames and answers PACKETRESEND for the camera (and says so in the
// capability register at 0x0934): what its link lost it can send again, over the same bad link.
//
// Which packets suffer is a function of seed, frame number and packet number, not of time. A late frame holds
// back everything behind it, as a congested link does.
//
// Everything may be called from any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace ulf::acquisition {

struct GigeLinkFaults {
  double lost = 0, doubled = 0, swapped = 0;  // shares of the stream's packets
  double late = 0;                            // share of the frames ...
  std::chrono::milliseconds late_by{0};       // ... that leave so much later
};

struct GigeRelayOptions {
  std::string camera;   // where the camera really is
  std::string address;  // where clients find it
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
  // Relays when it returns. Throws Error when an address cannot be had.
  explicit GigeRelay(const GigeRelayOptions& options);
  ~GigeRelay();
  GigeRelay(const GigeRelay&) = delete;
  GigeRelay& operator=(const GigeRelay&) = delete;

  void SetFaults(const GigeLinkFaults& faults);
  void SetLoss(double share);

  // What passes. A channel that does not pass swallows, without an answer, as a pulled cable does.
  void PassControl(bool passes);
  void PassStream(bool passes);
  void Pull();     // neither
  void PutBack();  // both

  GigeRelayStatistics Statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
