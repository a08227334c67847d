// `sim:SCENE`: the simulated camera as a device. Frames wait to be taken and simulated time advances by one
// period each, so that whoever reads it sees the same sequence however slow it is. For a camera that does not
// wait, serve it with `ulf simulate` and open it by `aravis:`.
//
// Faults (`fault=disconnect=5:2&fault=incomplete=0.1`, see simulated_faults.h) strike at simulated moments,
// and what comes after them is the same in every run. How long a freeze or a disconnection lasts is real
// time: nobody takes frames meanwhile that could advance the simulated one. A camera whose cable is out is
// lost (kLost) and cannot be opened by the same URI in this process until it is back; then it goes on as if
// the hand had moved on for as long, so that its frame numbers show the gap.
#pragma once

#include <memory>

#include "acquisition/device/device.h"
#include "acquisition/simulator/hand_motion.h"

namespace ulf::acquisition {

// Throws UsageError for an unknown scene, option or fault, Error while the cable is out. `hand`: who holds
// the camera; none for the hand that scans by a plan, as the URI describes it.
std::unique_ptr<Device> OpenSimulatedDevice(const DeviceUri& uri,
                                            std::shared_ptr<const HandMotion> hand = nullptr);

}  // namespace ulf::acquisition
