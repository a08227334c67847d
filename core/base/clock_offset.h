// How far a device's clock is from this computer's, learnt from frames: host clock - device clock, with the
// least delay that was seen, because nothing arrives before it was sent and some frame is never held up. The
// delay that every frame has (exposure, read-out, network) is part of it.
//
// Clocks drift (50 millionths are 3 ms in a minute), so that only the last half minute to a minute counts.
#pragma once

#include <cstdint>
#include <optional>

namespace ulf {

class ClockOffset {
 public:
  void Add(double device_time_s, double host_time_s);
  // None: no frame yet.
  std::optional<double> OffsetS() const;
  // Standard deviation of the delay; none with fewer than two frames.
  std::optional<double> JitterS() const;
  // How much longer than the least delay a frame took.
  double LatenessS(double device_time_s, double host_time_s) const;

 private:
  struct Window {
    double begin_host_s = 0, least_s = 0;
    double sum_s = 0, sum_squares = 0;  // of delay - reference_s_: small numbers, though clocks are large
    std::uint64_t count = 0;
  };
  Window past_, present_;
  double reference_s_ = 0;
};

}  // namespace ulf
