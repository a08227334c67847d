// What a camera puts on its link: the size of its packets and the pause between them (GigE Vision), and how many bytes a
// second it limits itself to.
#pragma once

#include <string>

#include "acquisition/aravis/aravis_configuration.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Writes what the options ask for and reads back what the camera took. `who` names the camera in errors. Throws
// UsageError for a setting that the camera does not have or take.
void WriteAravisLink(const AravisSession& session, const std::string& who, const AravisOptions& options,
                     const FeatureNames& names, AravisConfigured& configured);

}  // namespace ulf::acquisition
