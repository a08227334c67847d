// Makes a frame of a downloaded photograph; its pixels stay encoded.
#pragma once

#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/photograph_pairing.h"
#include "core/image/frame.h"
#include "core/image/jpeg_file.h"

namespace ulf::acquisition {

// Exposure and gain come from `exif`, else from the camera's settings. The time is that of the request plus
// the lag, or that of the announcement for a photograph released on the body.
Frame FrameOf(DownloadedPhotograph photograph, const ExifFacts& exif, const CameraSettings& settings,
              double shutter_lag_s);

}  // namespace ulf::acquisition
