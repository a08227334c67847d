// Lets a camera wait for triggers: of its software, or of one of its lines. Cameras differ in which triggers
// there are to choose from (feature_names.h): some have one alone and no choice, some show a choice that
// follows the mode, some start the exposure in place of the frame.
#pragma once

#include <string>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Switches every trigger off that can be: the camera runs free.
void ClearAravisTriggers(const AravisSession& session, const FeatureNames& names);

// Nothing where the options ask for no trigger. Returns what is to be said. Throws Refusal that begins with
// `who` for a trigger that the camera does not have.
std::vector<std::string> WriteAravisTrigger(const AravisSession& session, const std::string& who,
                                            const FeatureNames& names, const AravisOptions& options);

}  // namespace ulf::acquisition
