// Opens the simulated camera as a device: `sim:SCENE`, or for calibration sim:board, sim:card, sim:chart or
// sim:grey. Frames wait for Next(), and each advances simulated time by one period, so that a slow reader
// sees the same sequence as a fast one. `ulf simulate` serves a camera that does not wait, for `aravis:`.
//
// Faults (`fault=disconnect=5:2&fault=incomplete=0.1`, simulated_faults.h) begin at simulated times, and the
// frames after them are the same in every run. A freeze or a disconnection lasts for real time, because no
// frame advances simulated time meanwhile. A disconnected camera is lost (kLost) and cannot be opened by the
// same URI in this process until the disconnection ends; then the hand has moved on for the same time, and
// the frame numbers show the gap.
#pragma once

#include <memory>

#include "acquisition/device/device.h"
#include "acquisition/simulator/hand.h"

namespace ulf::acquisition {

// Throws Refusal for an unknown scene, option or fault, or one that needs a network, Error while the camera
// is disconnected. `hand`: the motion of the camera; null for the planned hand that the URI describes.
std::unique_ptr<Device> OpenSimulatedDevice(const DeviceUri& uri,
                                            std::shared_ptr<const HandMotion> hand = nullptr);

}  // namespace ulf::acquisition
