// Numbers of floating-point pictures that are no light, or are not likely to be: infinities and NaN, and levels of 8 or 16 bits.
#pragma once

#include "core/image/files/stored_picture.h"

namespace ulf {

// Of pixels as the file has them, before any conversion; other depths than CV_32F are passed over. All numbers stay as they are:
// those that are not finite are counted in a warning, and pixels that have one get no weight in renderings (photograph.h). Numbers
// of which nearly all are whole, and of which some are above full scale, are named in a warning as levels that were not divided.
void CheckFloatNumbers(StoredPicture& picture);

}  // namespace ulf
