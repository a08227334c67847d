// What is known of the colours in which a view's light is read.
#pragma once

#include "core/light_field/light_field.h"

namespace ulf {

// Whether it has Rec. 709 primaries without a colour profile: the camera encoded its picture as sRGB, or its raw file is
// developed by the file's own matrix. Else (a linear master) the colours are the sensor's own.
inline bool HasRec709Colors(const View& view) { return view.master_transfer != Transfer::kLinear; }

}  // namespace ulf
