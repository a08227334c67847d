// Cameras for Agisoft Metashape: File > Import > Import Cameras, "Agisoft XML". Conventions as metashape_set.h has them:
// sensors with f, b1 = fx - fy, the principal point counted from the middle, p1 and p2 the other way round than OpenCV's;
// camera-to-chunk transforms with our axes. Frame sensors have k1 k2 k3 p1 p2, fisheyes k1 to k4: nothing of a lens is lost.
// Cameras are labelled with their photograph's name without its ending.
#pragma once

#include <string>

#include "core/light_field/light_field.h"

namespace ulf {

std::string MetashapeXmlText(const LightField& exported);

}  // namespace ulf
