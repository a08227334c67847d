// Reads and writes white balance as the ratios of red and blue to green: a ratio for each colour, or, on
// cameras that have none, each colour's own gain.
#pragma once

#include <optional>
#include <string>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Returns none if the camera has no ratios, or they cannot be read now.
std::optional<AravisWhiteBalance> ReadWhiteBalance(const AravisSession& session, const FeatureNames& names);

// Requires ratios. Throws Refusal that begins with `who` for a ratio that is out of range or fixed.
void WriteWhiteBalance(const AravisSession& session, const std::string& who, const FeatureNames& names,
                       const AravisWhiteBalance& balance);

// Returns the distance of neighbouring ratios that the camera can have, the most that a written one is off.
double WhiteBalanceStep(const AravisSession& session, const FeatureNames& names);

}  // namespace ulf::acquisition
