// A downloaded photograph as a frame, its pixels still encoded.
#pragma once

#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/photograph_pairing.h"
#include "core/image/frame.h"
#include "core/image/jpeg_file.h"

namespace ulf::acquisition {

// What the photograph itself says (`exif`) goes before the camera's settings. Its time is that of the request
// and the lag; from the body, that of its announcement.
Frame FrameOf(DownloadedPhotograph photograph, const ExifFacts& exif, const CameraSettings& settings,
              double shutter_lag_s);

}  // namespace ulf::acquisition
