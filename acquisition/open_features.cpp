// From a URI's scheme to the settings of the device behind it.
#include "acquisition/aravis/aravis_features.h"
#include "acquisition/error.h"
#include "acquisition/features.h"

namespace ulf {

std::unique_ptr<FeatureAccess> OpenFeatures(const std::string& text) {
  const DeviceUri uri = DeviceUri::Parse(text);
  if (uri.scheme == "aravis") return OpenAravisFeatures(uri);
  throw UsageError("'{}': only cameras have features (aravis:ID); 'ulf devices' lists those in reach", text);
}

}  // namespace ulf
