// Controls the automatics of a machine-vision camera: exposure, gain, white balance, black level.
//
// The pictures of a light field must differ by viewpoint alone. Automatics that are on run until the camera
// has settled; then they are switched off and their values are kept, as for webcams (v4l2_controls.h), with a
// notice for each. An automatic that the URI names (auto_exposure=on) stays as the URI asks.
//
// Modes are Off, Once and Continuous by convention; some cameras have Manual and Auto, a switch or a number
// instead. An automatic whose modes are not known is left alone.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// The mode of an automatic. kNone: the camera has none; kUnknown: its mode has a word that is not known.
enum class AutomaticMode { kNone, kOff, kOnce, kOn, kUnknown };
AutomaticMode ModeOf(const AravisSession& session, const std::string& feature);
// Returns whether the automatic changes its value at present.
bool IsAutomaticOn(const AravisSession& session, const std::string& feature);
// Switches the automatic to a mode, where there is one. Returns why it does not have that mode ("GainAuto
// reads Auto and is read-only"), or an empty text.
std::string SwitchAutomatic(const AravisSession& session, const std::string& feature, AutomaticMode wanted);
// Returns the camera's word for a mode; empty if it has none.
std::string WordFor(const AravisSession& session, const std::string& feature, AutomaticMode mode);
// Switches off the automatic that would change a requested value (`asked`: "exposure_us=5000"). Returns a
// message, or an empty text. Throws Refusal that begins with `who` where it is on and stays on.
std::string SwitchOffFor(const AravisSession& session, const std::string& who, const std::string& asked,
                         const std::string& feature);

// Switches the automatics that the URI names on or off; returns messages about others. Throws Refusal where
// one cannot have the requested mode.
std::vector<std::string> WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                                               const AravisOptions& options);

// Lets the camera adjust its white balance once. The camera must be streaming.
void BalanceWhiteOnce(const AravisSession& session, const std::string& who);

// Returns whether any automatic is on that the URI does not name.
bool HasAutomaticOn(const AravisSession& session, const AravisOptions& options);

// The automatics that were switched off, with the values that they had reached.
struct AravisFrozen {
  std::vector<std::string> said;  // "auto_exposure off, held at exposure_us=5000", "auto_gain stays on: ..."
  std::vector<std::pair<std::string, std::string>> values;  // as options of the URI
};
AravisFrozen FreezeAravisAutomatics(const AravisSession& session, const AravisOptions& options);

}  // namespace ulf::acquisition
