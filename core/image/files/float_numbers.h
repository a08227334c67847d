// Numbers of floating-point pictures that are no light, or are not likely to be of a white at 1: infinities and NaN, levels, absolute light.
#pragma once

#include "core/image/files/stored_picture.h"

namespace ulf {

// Of pixels as the file has them, before any conversion; other depths than CV_32F are passed over. All numbers stay as they are:
// those that are not finite are counted in a warning, and pixels that have one get no weight in renderings (photograph.h). Where
// more than half of the numbers above 0 are brighter than white, a warning says so with the median and the largest.
void CheckFloatNumbers(StoredPicture& picture);

}  // namespace ulf
