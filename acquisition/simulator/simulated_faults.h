// Faults of a simulated camera, each given as `name=value`; several may be combined:
//
//   lost=0.005         share of stream packets lost on the way               network only
//   doubled=0.01       ... that arrive twice                                 network only
//   swapped=0.01       ... that arrive after their successor                 network only
//   resend=0           the camera does not resend lost packets               network only
//   late=80:0.1        delay in milliseconds, and share of delayed frames    network only
//   incomplete=0.05    share of frames whose lower part is missing           sim: only
//   freeze=5:2         no frames from second 5 on, for 2 s; the camera still answers
//   disconnect=5:2     the camera is disconnected from second 5 on, for 2 s
//   ptp_lost=5:3      no IEEE 1588 master from second 5 on, for 3 s           network only
//   drift=0.5          the light on the sensor grows by so many stops per minute, without being reported
//   bluer=0.5          the lamp's blue grows, and its red falls, by so many stops per minute
//   flicker=100:0.4    lamps that flicker, in hertz, by this share of their light
//   defocus=3          the lens is out of focus: each point's image is a disc of this radius in pixels
//   hunting=4:1.6      an automatic focus goes to and fro: pixels of radius at its farthest, seconds a cycle
//   lens=0.9           the lens's focal length over that of the calibration stored for the camera
//   dust=5             so many spots on the lens
//   auto_exposure=told the exposure follows the picture; `untold`: without being reported    sim: only
//
// Seconds count from the first frame.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/simulator/imperfections.h"

namespace ulf::acquisition {

struct FaultSpan {
  double at_s = 0, for_s = 0;
  bool Holds(double t_s) const { return t_s >= at_s && t_s < at_s + for_s; }
};

// Describes what a faulty network link does to the camera's packets (gige/gige_relay.h).
struct GigeLinkFaults {
  double lost = 0, doubled = 0, swapped = 0;  // shares of the stream's packets
  double late = 0;                            // share of the frames that are delayed ...
  std::chrono::milliseconds late_by{0};       // ... by this time
};

enum class AutoExposure { kOff, kTold, kUntold };

struct SimulatedFaults {
  GigeLinkFaults link;
  bool resends = true;
  double incomplete = 0;
  std::vector<FaultSpan> freezes, disconnects, masters_lost;
  double drift_stops_per_minute = 0, bluer_stops_per_minute = 0;
  LampFlicker flicker;
  double defocus_px = 0;
  FocusHunt hunting;
  double focal_ratio = 1;  // of the lens that is mounted
  int dust_spots = 0;
  AutoExposure auto_exposure = AutoExposure::kOff;

  // Throws Refusal that names an unknown fault or a value out of range.
  void Add(const std::string& text);
  // Returns whether these faults are those of a network link.
  bool NeedRelay() const;

  bool Frozen(double t_s) const { return AnyHolds(freezes, t_s); }
  bool Disconnected(double t_s) const { return AnyHolds(disconnects, t_s); }
  bool MasterLost(double t_s) const { return AnyHolds(masters_lost, t_s); }
  // Returns whether a picture depends on when it is taken, not on the hand alone.
  bool ChangeWithTime() const {
    return drift_stops_per_minute != 0 || bluer_stops_per_minute != 0 || flicker.depth > 0 ||
           hunting.radius_px > 0;
  }
  // Returns the factors on the light's R G B at a time.
  std::array<double, 3> Light(double t_s) const;

 private:
  static bool AnyHolds(const std::vector<FaultSpan>& spans, double t_s) {
    return std::any_of(spans.begin(), spans.end(), [t_s](const FaultSpan& span) { return span.Holds(t_s); });
  }
};

// Returns the names of all faults.
std::vector<std::string> SimulatedFaultNames();

}  // namespace ulf::acquisition
