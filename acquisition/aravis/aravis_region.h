// Sets the part of the sensor that a camera sends, and its binning.
//
// A camera accepts widths, heights and offsets within limits and in steps of its own, and these limits depend
// on each other. They follow from the pixel format, the binning and offsets of zero, which are therefore
// written first; then the region is checked and its size written. Some cameras limit the offsets further once
// the size is set, so the limits are read again before the offsets are written. If the size is fixed, the
// camera's limits of the offsets hold, and those of its sensor. For a Bayer mosaic the offsets must be even:
// an odd one shifts the colours, and makers differ in whether the camera then names another pattern.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// Describes the right and lower end of the pixels that the camera can send, in pixels of the image with the
// present binning: the largest image or, for a fixed size, what the offsets reach; 0: no limit.
struct AravisImageLimits {
  int width = 0, height = 0;
};

// Writes the region `asked`; none: the whole image, or what the camera has fixed, which is added to `notes`.
// Throws Refusal that names the nearest region that the camera can send. `is_mosaic`: of a Bayer pattern.
AravisImageLimits WriteAravisRegion(const AravisSession& session, const std::string& who,
                                    const std::optional<AravisRegion>& asked, bool is_mosaic,
                                    std::vector<std::string>& notes);

// Returns how many pixels of the sensor become one of the image by a feature of one axis (BinningHorizontal,
// DecimationVertical, ...): 1 if the camera does not have it. The feature is a number on some cameras, on
// others a choice whose name ends with the number (BinningHorizontal2).
int ReductionOf(const AravisSession& session, const char* feature);

// Writes the binning; 1 undoes it as far as the camera can. Throws Refusal for a higher one that it lacks.
void WriteAravisBinning(const AravisSession& session, const std::string& who, const AravisBinning& asked);

}  // namespace ulf::acquisition
