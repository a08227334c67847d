// Sets the part of the sensor that a camera sends, and its binning.
//
// A camera accepts widths, heights and offsets within limits and in steps of its own, and these limits depend
// on each other. They follow from the pixel format, the binning and offsets of zero, which are therefore
// written first; then the region is checked and its size written. Some cameras limit the offsets further once
// the size is set, so the limits are read again before the offsets are written. Beside a size that is fixed,
// the camera's own limits of the offsets and the size of its sensor count. For a mosaic the offsets must be
// even: an odd one shifts the colours, and makers differ in whether the camera then names another pattern.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// Describes the right and lower limit of pixels that the camera can send with the present binning: the
// largest image or, beside a fixed size, what the offsets reach; 0: no limit.
struct AravisImageLimits {
  int width = 0, height = 0;
};

// Writes `asked`, in pixels of the image after binning; none: the whole image, or what the camera has fixed,
// which is added to `notes`. Throws Refusal that names the nearest region that the camera can send.
AravisImageLimits WriteAravisRegion(const AravisSession& session, const std::string& who,
                                    const std::optional<AravisRegion>& asked, bool is_mosaic,
                                    std::vector<std::string>& notes);

// Returns how many pixels of the sensor become one of the image along one axis: 1 where the camera has no
// such feature (BinningHorizontal, DecimationVertical, ...). Some cameras have a number, others a choice
// whose name ends with it (BinningHorizontal2).
int ReductionOf(const AravisSession& session, const char* feature);

// Throws Refusal for a binning that the camera does not have. Without a request binning is undone.
void WriteAravisBinning(const AravisSession& session, const std::string& who, const AravisBinning& asked);

}  // namespace ulf::acquisition
