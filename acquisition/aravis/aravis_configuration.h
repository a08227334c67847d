// Writes a camera's whole configuration, because it keeps the last program's settings, and reads it back.
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
  double gain = 1;                // linear; 1 also if unknown
  double black_level = 0;         // as a share of full scale
  double period_s = 0;            // 0: unknown
  std::optional<double> set_fps;  // the frame rate that is set; none: there is no such setting, or it is off
  std::size_t payload_bytes = 0;  // of a frame's buffer: image and chunk data
  AravisLink link;
  std::vector<std::string> chunks;  // chunk data that are switched on: "ExposureTime"
  std::vector<std::string> notes;   // ends of messages that begin with "the camera ": "changed fps=30 to 25"
};

// `who` names the camera in errors. Throws Refusal for a requested setting that the camera does not have or
// take, Error for a camera without a supported pixel format, or one that does not answer.
AravisConfigured ConfigureAravis(const AravisSession& session, const std::string& who,
                                 const AravisOptions& options);

// Reads the present exposure, gain and black level into `configured`, and changes nothing else there.
void ReadLight(const AravisSession& session, const std::string& who, AravisConfigured& configured);

// Switches off chunk data, for a camera that announces but does not send them, and corrects `configured`.
// Throws Error if the camera keeps them on.
void SwitchChunksOff(const AravisSession& session, const std::string& who, AravisConfigured& configured);

}  // namespace ulf::acquisition
