// Defines faults of a simulated camera, each given as `name=value`; several may be combined. Their names and
// values are those of docs/devices.md#the-simulated-camera-sim-and-ulf-simulate, which says which of them
// need a network. Seconds count from the first frame.
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

// Whether the exposure follows the picture, and whether Frame::exposure_s then tells it.
enum class AutoExposure { kOff, kTold, kUntold };

struct SimulatedFaults {
  GigeLinkFaults link;
  bool resends = true;    // whether lost packets are sent again
  double incomplete = 0;  // share of the frames whose lower part is missing
  // When no frames come although the camera answers, when the cable is out, and when no PTP master is there.
  std::vector<FaultSpan> freezes, disconnects, masters_lost;
  // The light on the sensor grows, and the lamp's blue grows and its red falls, without being reported.
  double drift_stops_per_minute = 0, bluer_stops_per_minute = 0;
  LampFlicker flicker;
  double defocus_px = 0;  // radius of a point's image
  FocusHunt hunting;
  double focal_ratio = 1;  // of the lens that is mounted
  int dust_spots = 0;
  AutoExposure auto_exposure = AutoExposure::kOff;

  // Adds a fault, `name=value`. Throws Refusal that names an unknown fault or a value out of range.
  void Add(const std::string& text);
  // Returns whether any of the faults is one that a relay makes on a network.
  bool NeedRelay() const;

  bool Frozen(double t_s) const { return AnyHolds(freezes, t_s); }
  bool Disconnected(double t_s) const { return AnyHolds(disconnects, t_s); }
  bool MasterLost(double t_s) const { return AnyHolds(masters_lost, t_s); }
  // Returns whether a picture depends on when it is taken, and not on the hand's place alone.
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
