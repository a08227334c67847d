// Controls the automatics of a machine-vision camera: exposure, gain, white balance, black level.
//
// The pictures of a light field must differ by viewpoint alone. Automatics that are on run until the camera
// has settled; then they are switched off and their values are kept, as for webcams (v4l2_controls.h), with a
// notice for each. An automatic that the URI names (auto_exposure=on) stays as the URI asks.
//
// By convention (SFNC) the modes are Off, Once and Continuous; some cameras have Manual and Auto, a switch or
// a number instead. An automatic whose mode has an unknown word is left as it is.
//
// `feature`: the camera's name of the automatic, "GainAuto". `who`: the URI, with which errors begin.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// kNone: the camera does not have the automatic. kUnknown: its mode has an unknown word, or cannot be read.
enum class AutomaticMode { kNone, kOff, kOnce, kOn, kUnknown };
AutomaticMode ModeOf(const AravisSession& session, const std::string& feature);
// Returns whether the mode is kOnce or kOn.
bool IsAutomaticOn(const AravisSession& session, const std::string& feature);
// Switches the automatic, if the camera has it, to a mode. Returns why it does not have that mode ("GainAuto
// reads Auto and is read-only"), or an empty text.
std::string SwitchAutomatic(const AravisSession& session, const std::string& feature, AutomaticMode wanted);
// Returns the camera's word for a mode; empty if the camera has no such mode.
std::string WordFor(const AravisSession& session, const std::string& feature, AutomaticMode mode);
// Switches off the automatic that would change a requested value (`asked`: "exposure_us=5000"). Returns an
// empty text, or a message if the mode stays unknown. Throws Refusal if the automatic stays on.
std::string SwitchOffFor(const AravisSession& session, const std::string& who, const std::string& asked,
                         const std::string& feature);

// Switches the automatics that the URI names on or off. Returns a message about each other automatic whose
// mode is unknown. Throws Refusal if a named one cannot have its mode.
std::vector<std::string> WriteAravisAutomatics(const AravisSession& session, const std::string& who,
                                               const AravisOptions& options);

// Makes a streaming camera adjust its white balance once, without waiting for that. Throws Refusal.
void BalanceWhiteOnce(const AravisSession& session, const std::string& who);

// Returns whether any automatic is on that the URI does not name.
bool HasAutomaticOn(const AravisSession& session, const AravisOptions& options);

struct AravisFrozen {
  std::vector<std::string> said;  // "auto_exposure off, held at exposure_us=5000", "auto_gain stays on: ..."
  std::vector<std::pair<std::string, std::string>> values;  // held, as options of the URI
};
// Switches off the automatics that are on and that the URI does not name, and holds their values.
AravisFrozen FreezeAravisAutomatics(const AravisSession& session, const AravisOptions& options);

}  // namespace ulf::acquisition
