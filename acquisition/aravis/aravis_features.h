// The GenICam tree of a machine-vision camera, for `ulf features`.
//
// What stands in a category is listed, those outside the tree last; Find() also knows what no category holds
// (some makers leave AcquisitionFrameRate out). A camera that another program controls can be read, not set.
#pragma once

#include <memory>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

std::unique_ptr<FeatureAccess> OpenAravisFeatures(const DeviceUri& uri);

}  // namespace ulf::acquisition
