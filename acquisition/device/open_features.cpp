// From a URI's scheme to the settings of the device behind it.
#include "acquisition/aravis/aravis_features.h"
#include "acquisition/device/features.h"
#include "acquisition/gphoto2/gphoto_device.h"
#include "acquisition/v4l2/v4l2_features.h"
#include "core/base/error.h"

namespace ulf::acquisition {

std::unique_ptr<FeatureAccess> OpenFeatures(const std::string& text) {
  const DeviceUri uri = DeviceUri::Parse(text);
  if (uri.scheme == "aravis") return OpenAravisFeatures(uri);
  if (uri.scheme == "v4l2") return OpenV4l2Features(uri);
  if (uri.scheme == "gphoto2") return OpenGphotoFeatures(uri);
  throw UsageError(
      "'{}': only cameras have features (aravis:ID, v4l2:/dev/video0, gphoto2:ID); 'ulf devices' lists those "
      "in reach",
      text);
}

}  // namespace ulf::acquisition
