// A webcam's controls as features, for `ulf features`: named as v4l2-ctl names them (the short names of
// v4l2_controls.h are accepted too) and grouped as in the driver. This works also while another program
// streams from the camera.
#pragma once

#include <memory>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

std::unique_ptr<FeatureAccess> OpenV4l2Features(const DeviceUri& uri);

}  // namespace ulf::acquisition
