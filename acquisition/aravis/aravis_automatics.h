// The automatics of a machine-vision camera: exposure, gain, white balance, black level.
//
// The pictures of a light field must differ by viewpoint alone. Automatics that are on run until the camera
// has settled; then they are switched off and their values are kept, as for webcams (v4l2_controls.h), with a
// notice for each. An automatic that the URI names (auto_exposure=on) stays as the URI asks.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// Switches the automatics that the URI names on or off. Throws UsageError where one should be on that the
// camera does not have.
void WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                           const AravisOptions& options);

// Whether any is on that the URI does not ask for.
bool HasAutomaticOn(const AravisSession& session, const AravisOptions& options);

// Switches those off and writes back the values that they had reached.
struct AravisFrozen {
  std::vector<std::string> said;  // "auto_exposure off, held at exposure_us=5000", "auto_gain stays on: ..."
  std::vector<std::pair<std::string, std::string>> values;  // as options of the URI
};
AravisFrozen FreezeAravisAutomatics(const AravisSession& session, const AravisOptions& options);

}  // namespace ulf::acquisition
