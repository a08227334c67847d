// Estimates the difference of two clocks, host clock - device clock, from the arrival of frames: the smallest
// difference seen, because that frame was held up least. The estimate includes the delay that every frame has
// (exposure, readout, network).
//
// Clocks drift (50 ppm are 3 ms in a minute), so only the last 30 to 60 s count.
#pragma once

#include <cstdint>
#include <optional>

namespace ulf {

class ClockOffset {
 public:
  // Takes a frame's time stamp by the device's clock and its arrival by the host's.
  void Add(double device_time_s, double host_time_s);
  // Returns the offset in seconds; none before the first frame.
  std::optional<double> OffsetS() const;
  // Returns the standard deviation of the delay in seconds; none with fewer than two frames.
  std::optional<double> JitterS() const;
  // Returns by how many seconds this frame took longer than the fastest added one; 0 if none was added.
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
