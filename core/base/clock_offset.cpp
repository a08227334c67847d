#include "core/base/clock_offset.h"

#include <algorithm>
#include <cmath>

namespace ulf {
namespace {

// Half of the time that counts. Longer: drift adds 1.5 ms per 30 s at 50 ppm; shorter: fewer frames without a
// delay. Guessed.
constexpr double kWindowS = 30;

}  // namespace

void ClockOffset::Add(double device_time_s, double host_time_s) {
  const double delay_s = host_time_s - device_time_s;
  if (host_time_s < present_.begin_host_s) past_ = present_ = {};  // the host's clock was set back
  if (past_.count + present_.count == 0) reference_s_ = delay_s;
  if (present_.count > 0 && host_time_s - present_.begin_host_s > kWindowS) {
    past_ = present_;
    present_ = {};
  }
  if (present_.count == 0) {
    present_.begin_host_s = host_time_s;
    present_.least_s = delay_s;
  }
  present_.least_s = std::min(present_.least_s, delay_s);
  present_.sum_s += delay_s - reference_s_;
  present_.sum_squares += (delay_s - reference_s_) * (delay_s - reference_s_);
  ++present_.count;
}

std::optional<double> ClockOffset::OffsetS() const {
  if (present_.count == 0) return std::nullopt;
  return past_.count > 0 ? std::min(past_.least_s, present_.least_s) : present_.least_s;
}

std::optional<double> ClockOffset::JitterS() const {
  const auto count = static_cast<double>(past_.count + present_.count);
  if (count < 2) return std::nullopt;
  const double mean = (past_.sum_s + present_.sum_s) / count;
  return std::sqrt(std::max(0.0, (past_.sum_squares + present_.sum_squares) / count - mean * mean));
}

double ClockOffset::LatenessS(double device_time_s, double host_time_s) const {
  const auto offset_s = OffsetS();
  return offset_s ? host_time_s - device_time_s - *offset_s : 0;
}

}  // namespace ulf
