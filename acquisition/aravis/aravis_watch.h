// Decides when a camera that sends no frames counts as stalled, and when as lost. One object serves one
// stream and belongs to the thread that takes its frames.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// A stream counts as stalled after at least so many frame periods. Guessed.
inline constexpr double kStallPeriods = 3;

class AravisWatch {
 public:
  // `period_s`: of the frames; 0: unknown.
  AravisWatch(const AravisSession& session, double period_s);

  double StallSeconds() const;  // time without a frame that is due, after which the stream counts as stalled
  // `gap_s`: time since the frame before. A camera that is regularly slower than its setting is not stalled.
  void FrameCame(double gap_s);
  // Returns why the camera is lost; none if it is not. While no frame comes, this asks the camera who
  // controls it: a camera that was restarted has no controller, and the library's heartbeat reports that up
  // to five seconds later. `silence_s`: time without a frame that is due. `refused_packets`: how many packets
  // the guard refused so far (stream_guard.h).
  std::optional<std::string> LossReason(double silence_s, bool waits_for_trigger,
                                        std::uint64_t refused_packets);

 private:
  using Clock = std::chrono::steady_clock;

  // Returns the longer of the period that is set and that of the last frames.
  double PeriodSeconds() const;

  const AravisSession& session_;
  const double period_s_;
  std::array<double, 3> gaps_s_{};  // the last
  const std::string gige_address_;  // empty: another bus
  Clock::time_point asked_control_at_ = Clock::now();
  bool control_answered_ = true;
};

}  // namespace ulf::acquisition
