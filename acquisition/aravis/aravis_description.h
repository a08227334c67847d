// Reads a camera's GenICam description, as Aravis has parsed it (a node for each feature).
#pragma once

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Returns the type of a feature; none for null, a category, a port or a bare register.
std::optional<FeatureType> KindOf(ArvGcNode* node);
// Returns the value as text ("Off", "true", "512"), empty for an enumeration whose register has none of its
// numbers; none if the camera does not return it, or the node has no value.
std::optional<std::string> ValueOf(ArvGcNode* node);
// Returns the features that a description names. It asks no camera, so all of them count as available.
NamedFeatures FeaturesOf(ArvGc* description);
// Returns the features that the camera has, available now or not, with the choices that are available now.
NamedFeatures FeaturesOf(ArvCamera* camera);

}  // namespace ulf::acquisition
