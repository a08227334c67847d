// Writes a camera's whole configuration, because a camera keeps the settings of the last program, and reads
// back what the camera accepted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_link.h"
#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "core/frames/pixel_format.h"

namespace ulf::acquisition {

// The configuration as the camera reports it afterwards.
struct AravisConfigured {
  PixelFormat format;
  int width = 0, height = 0;
  SensorWindow window;
  double exposure_s = 0;          // 0: unknown
  double gain = 1;                // linear
  double black_level = 0;         // as a share of full scale
  double period_s = 0;            // 0: unknown
  std::optional<double> set_fps;  // what its frame rate is set to; none: it has none, or it is switched off
  std::size_t payload_bytes = 0;  // room for a frame
  AravisLink link;
  std::vector<std::string> chunks;  // switched on
  std::vector<std::string> notes;   // settings that the camera changed, for messages
};

// `who` names the camera in errors. Throws Refusal for a setting that the camera does not have or take.
AravisConfigured ConfigureAravis(const AravisSession& session, const std::string& who,
                                 const AravisOptions& options);

// Reads the present exposure, gain and black level into `configured`.
void ReadLight(const AravisSession& session, const std::string& who, AravisConfigured& configured);

// Switches off chunk data that a camera announces and does not send; its payload shrinks. Throws Error.
void SwitchChunksOff(const AravisSession& session, const std::string& who, AravisConfigured& configured);

}  // namespace ulf::acquisition
