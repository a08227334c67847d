// Lets a camera wait for triggers, by software or on one of its input lines (GenICam SFNC TriggerSelector,
// TriggerMode, TriggerSource). Cameras differ in their triggers (feature_names.h): some have a single one
// without a selector, on some the choices depend on the mode, some start the exposure and not the frame.
#pragma once

#include <string>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Switches off every trigger, as far as the camera allows, so that the camera runs free.
void ClearAravisTriggers(const AravisSession& session, const FeatureNames& names);

// Sets the trigger that the options name; does nothing where they name none. Returns messages for people.
// Throws Refusal that begins with `who` for a trigger that the camera does not have.
std::vector<std::string> WriteAravisTrigger(const AravisSession& session, const std::string& who,
                                            const FeatureNames& names, const AravisOptions& options);

}  // namespace ulf::acquisition
