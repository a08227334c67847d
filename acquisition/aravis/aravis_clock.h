// Synchronises a camera's clock with others on its network by IEEE 1588 (Precision Time Protocol, PTP):
// switches PTP on, waits until the camera follows its master, and reads the offset. Features have the names
// of GenICam's SFNC (PtpEnable) or of older GigE Vision cameras (GevIEEE1588).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/device/transport_figures.h"

namespace ulf::acquisition {

struct ClockState {
  std::string status;  // the state of the PTP port, in the camera's word: "Slave", "Listening", ...
  std::optional<double> offset_ns;  // of the camera's clock from its master's; none: the camera does not tell
  // Returns whether the clock follows a master or is the master.
  bool IsShared() const { return status == "Slave" || status == "Master"; }
};

class AravisClock {
 public:
  // Switches PTP on or off if AravisOptions::ptp says so. Switched on, it waits at most ptp_wait_s for the
  // clock to be shared, and adds to `notes` "follows an IEEE 1588 clock after 1.2 s, 180 ns from it". Throws
  // Refusal for a camera without PTP, Error if the clock is not shared in time. `session` must outlive this.
  AravisClock(const AravisSession& session, const std::string& who, const AravisOptions& options,
              std::vector<std::string>& notes);

  // Returns false also if PTP is off or the camera does not have it.
  bool IsShared() const { return state_ && state_->IsShared(); }
  // Adds the figures of the clock for DeviceStatistics::transport.
  void AppendTo(TransportFigures& transport) const;
  // Asks the camera, at most once a second. Returns a message when the clock begins or ceases to be shared.
  std::optional<std::string> Poll();

 private:
  std::optional<ClockState> Query() const;

  const AravisSession& session_;
  std::optional<ClockState> state_;  // none: PTP is off, or the camera does not have it
  std::chrono::steady_clock::time_point asked_;
};

}  // namespace ulf::acquisition
