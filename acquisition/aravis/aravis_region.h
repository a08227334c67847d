// Which part of the sensor a camera sends. Its limits follow from the pixel format, the binning and offsets
// of zero, which are therefore written first; the region is then checked against them before its size is
// written. Cameras that limit the offsets further, once they know the size, are asked again before these are.
//
// A camera takes widths, heights and offsets within limits and in steps of its own, and the limits of one
// depend on another. Of a mosaic the offsets must be even besides: an odd one moves the colours by a pixel,
// and whether a camera then names another pattern is its maker's choice.
#pragma once

#include <optional>
#include <string>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// The largest image that the camera sends as it is binned.
struct AravisImageLimits {
  int width = 0, height = 0;
};

// Writes `asked`, in pixels of the image, or else the whole image. Throws UsageError with the nearest region
// that the camera can send.
AravisImageLimits WriteAravisRegion(const AravisSession& session, const std::string& who,
                                    const std::optional<AravisRegion>& asked, bool is_mosaic);

}  // namespace ulf::acquisition
