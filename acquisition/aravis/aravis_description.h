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
// Answers from a description, which must outlive the answers. No camera is asked: all features
// count as available.
NamedFeatures FeaturesOf(ArvGc* description);
// Asks the camera, which must outlive the answers, at each call; offers the choices available now. A failed
// call answers as for a missing feature.
NamedFeatures FeaturesOf(ArvCamera* camera);

}  // namespace ulf::acquisition
