// A webcam's controls as features, for `ulf features`: names as v4l2-ctl shows them (the short ones of
// v4l2_controls.h are understood too), grouped as the driver groups them. A camera that streams elsewhere can
// be read and set all the same.
#pragma once

#include <memory>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

std::unique_ptr<FeatureAccess> OpenV4l2Features(const DeviceUri& uri);

}  // namespace ulf::acquisition
