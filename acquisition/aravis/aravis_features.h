// The GenICam tree of a machine-vision camera, for `ulf features`.
//
// List() returns the features of all categories, those outside the tree last; Find() also finds features that
// are in no category (some makers leave AcquisitionFrameRate out). A camera that another program controls can
// be read, not written.
#pragma once

#include <memory>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

std::unique_ptr<FeatureAccess> OpenAravisFeatures(const DeviceUri& uri);

}  // namespace ulf::acquisition
