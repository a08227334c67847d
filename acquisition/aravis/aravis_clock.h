// Synchronises a camera's clock with others on its network by IEEE 1588 (PTP): switches that on, waits until
// the camera follows its master, and reads the offset. Features have the names of GenICam's SFNC (PtpEnable)
// or of older GigE Vision cameras (GevIEEE1588).
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
  std::optional<double> offset_ns;  // from its master; none: the camera does not tell
  // Returns whether the clock follows a master or is the master.
  bool IsShared() const { return status == "Slave" || status == "Master"; }
};

class AravisClock {
 public:
  // Switches IEEE 1588 on or off where the options say so, and waits AravisOptions::ptp_wait_s for the clock
  // to be shared. Throws Refusal for a camera without it, Error when the time is over. Adds to `notes`
  // "follows an IEEE 1588 clock after 1.2 s, 180 ns from it".
  AravisClock(const AravisSession& session, const std::string& who, const AravisOptions& options,
              std::vector<std::string>& notes);

  // Returns false, too, where IEEE 1588 is off or the camera does not have it.
  bool IsShared() const { return state_ && state_->IsShared(); }
  // Adds the figures of the clock for DeviceStatistics::transport.
  void AppendTo(TransportFigures& transport) const;
  // Asks the camera, at most once a second. Returns a message about what changed, or none.
  std::optional<std::string> Poll();

 private:
  std::optional<ClockState> Query() const;

  const AravisSession& session_;
  std::optional<ClockState> state_;  // none: it is off, or the camera does not have it
  std::chrono::steady_clock::time_point asked_;
};

}  // namespace ulf::acquisition
