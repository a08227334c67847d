// Reads and writes white balance as the ratios of red and blue to green: a ratio for each colour, or, on
// cameras that have none, each colour's own gain.
#pragma once

#include <optional>
#include <string>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

// Returns none when the camera has no ratios, or does not tell them now.
std::optional<AravisWhiteBalance> ReadWhiteBalance(const AravisSession& session, const FeatureNames& names);

// The camera must have ratios. Throws Refusal that begins with `who` for a ratio that it does not take.
void WriteWhiteBalance(const AravisSession& session, const std::string& who, const FeatureNames& names,
                       const AravisWhiteBalance& balance);

// Returns by how much a ratio may be off after it was written.
double WhiteBalanceStep(const AravisSession& session, const FeatureNames& names);

}  // namespace ulf::acquisition
