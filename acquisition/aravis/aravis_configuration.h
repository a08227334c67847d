// Writes a camera's whole configuration and reads back what it made of it: a camera keeps what the last
// program wrote.
#pragma once

#include <string>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/pixel_format.h"

namespace ulf {

// What the camera says it does after everything was written.
struct AravisConfigured {
  PixelFormat format;
  int width = 0, height = 0;
  double exposure_s = 0;  // 0: unknown
  double gain = 1;        // linear
  double period_s = 0;    // 0: unknown
  std::size_t payload_bytes = 0;
};

// `who` names the camera in errors. Throws Error for a setting that the camera does not have or take.
AravisConfigured ConfigureAravis(const AravisSession& session, const std::string& who,
                                 const AravisOptions& options);

}  // namespace ulf
