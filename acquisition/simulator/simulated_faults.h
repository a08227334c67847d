// What may go wrong with a simulated camera on request, each as `name=value`, any number at once:
//
//   lost=0.005         share of stream packets lost on the way               network only
//   doubled=0.01       ... that arrive twice                                 network only
//   swapped=0.01       ... that arrive after their successor                 network only
//   resend=0           the camera does not send again what was lost          network only
//   late=80:0.1        milliseconds and share of frames that leave so late   network only
//   incomplete=0.05    share of frames whose lower part is missing           sim: only
//   freeze=5:2         no frames from second 5 on, for 2 s; the camera still answers
//   disconnect=5:2     the cable is out from second 5 on, for 2 s
//   drift=0.5          the light that reaches the sensor grows by so many stops a minute, unreported
//
// Seconds count from the first frame that was taken.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/simulator/gige/gige_relay.h"

namespace ulf::acquisition {

struct FaultSpan {
  double at_s = 0, for_s = 0;
  bool Holds(double t_s) const { return t_s >= at_s && t_s < at_s + for_s; }
};

struct SimulatedFaults {
  GigeLinkFaults link;
  bool resends = true;
  double incomplete = 0;
  std::vector<FaultSpan> freezes, disconnects;
  double drift_stops_per_minute = 0;

  // Throws UsageError naming what is unknown or out of range.
  void Add(const std::string& text);
  // Whether packets must pass a relay for these.
  bool NeedRelay() const;

  bool Frozen(double t_s) const { return Any(freezes, t_s); }
  bool Disconnected(double t_s) const { return Any(disconnects, t_s); }
  // The light at a time as a multiple of what it should be.
  double Light(double t_s) const;

 private:
  static bool Any(const std::vector<FaultSpan>& spans, double t_s) {
    for (const FaultSpan& span : spans)
      if (span.Holds(t_s)) return true;
    return false;
  }
};

// Every fault's name.
std::vector<std::string> SimulatedFaultNames();

}  // namespace ulf::acquisition
