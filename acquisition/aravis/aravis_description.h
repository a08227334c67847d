// Converts a camera's GenICam description, as the library has parsed it, to names (feature_names.h).
#pragma once

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Returns none for a category, a port, a bare register.
std::optional<FeatureType> KindOf(ArvGcNode* node);
// Returns the value as text ("Off", "true", "512"), empty where an enumeration's register has none of its
// numbers; none: the camera does not return it, or the node has none.
std::optional<std::string> ValueOf(ArvGcNode* node);
// Returns what the description names, whether or not a camera has it at this moment: it is not asked, and
// need not be there.
NamedFeatures FeaturesOf(ArvGc* description);
// Returns what the camera has, whether or not it is available at this moment, with the choices that are.
NamedFeatures FeaturesOf(ArvCamera* camera);

}  // namespace ulf::acquisition
