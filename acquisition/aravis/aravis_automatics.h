// The automatics of a machine-vision camera: exposure, gain, white balance, black level.
//
// The pictures of a light field must differ by viewpoint alone. Automatics that are on run until the camera
// has settled; then they are switched off and their values are kept, as for webcams (v4l2_controls.h), with a
// notice for each. An automatic that the URI names (auto_exposure=on) stays as the URI asks.
//
// Cameras write Off, Once and Continuous (the convention), Manual and Auto, or have a switch or a number: a
// word is understood by its meaning. An automatic whose words nobody knows, or which has none, is left alone.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// What an automatic does. kNone: the camera has no such automatic; kUnknown: it says so in no word that is
// known.
enum class AutomaticMode { kNone, kOff, kOnce, kOn, kUnknown };
AutomaticMode ModeOf(const AravisSession& session, const std::string& feature);
// Whether it changes what it controls.
bool IsAutomaticOn(const AravisSession& session, const std::string& feature);
// Switches it, unless it is so, or not there. Returns why it is not: "GainAuto reads Auto and is read-only";
// empty: it is.
std::string SwitchAutomatic(const AravisSession& session, const std::string& feature, AutomaticMode wanted);
// The camera's word for it; empty: it has none.
std::string WordFor(const AravisSession& session, const std::string& feature, AutomaticMode mode);
// For a value that was asked for by name (`asked`: "exposure_us=5000") and that the automatic would change.
// Returns what is to be said; empty: nothing. Throws Refusal that begins with `who` where it is on and stays
// on.
std::string SwitchOffFor(const AravisSession& session, const std::string& who, const std::string& asked,
                         const std::string& feature);

// Switches the automatics that the URI names on or off; returns what is to be said of others. Throws Refusal
// where one cannot be as it is asked for.
std::vector<std::string> WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                                               const AravisOptions& options);

// Lets the camera adjust its white balance once. The camera must be streaming.
void BalanceWhiteOnce(const AravisSession& session, const std::string& who);

// Whether any is on that the URI does not ask for.
bool HasAutomaticOn(const AravisSession& session, const AravisOptions& options);

// Switches those off and writes back the values that they had reached.
struct AravisFrozen {
  std::vector<std::string> said;  // "auto_exposure off, held at exposure_us=5000", "auto_gain stays on: ..."
  std::vector<std::pair<std::string, std::string>> values;  // as options of the URI
};
AravisFrozen FreezeAravisAutomatics(const AravisSession& session, const AravisOptions& options);

}  // namespace ulf::acquisition
