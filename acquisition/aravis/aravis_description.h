// Converts a camera's GenICam description, as the library has parsed it, to names (feature_names.h).
#pragma once

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// kNone: a category, a port, a bare register.
NodeKind KindOf(ArvGcNode* node);
// Returns what the description names, whether or not a camera has it at this moment: it is not asked, and
// need not be there.
NamedFeatures FeaturesOf(ArvGc* description);
// Returns what the camera has, whether or not it is available at this moment, with the choices that are.
NamedFeatures FeaturesOf(ArvCamera* camera);

}  // namespace ulf::acquisition
