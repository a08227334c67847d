// What a camera changes by itself between two pictures: exposure, gain, white balance, black level.
//
// A light field's pictures must differ by viewpoint alone. Automatics that the camera was left with run until
// it has settled, are then switched off, and hold what they had reached, as a webcam's do (v4l2_controls.h);
// each is said. One that the URI names (auto_exposure=on) stays as it is asked to be.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// Switches those on and off that the URI names. Throws UsageError for one to be on that the camera has not.
void WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                           const AravisOptions& options);

// Whether any is on that the URI does not ask for.
bool HasAutomaticOn(const AravisSession& session, const AravisOptions& options);

// Switches those off, and writes what they had reached.
struct AravisFrozen {
  std::vector<std::string> said;  // "auto_exposure off, held at exposure_us=5000", "auto_gain stays on: ..."
  std::vector<std::pair<std::string, std::string>> values;  // as options of the URI
};
AravisFrozen FreezeAravisAutomatics(const AravisSession& session, const AravisOptions& options);

}  // namespace ulf::acquisition
