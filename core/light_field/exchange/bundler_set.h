// Bundler's bundle.out (v0.3) with its list of photographs: cameras, points and their observations.
//
// Manual of Bundler 0.4, "Output format and scene representation" (cs.cornell.edu/~snavely/bundler):
//   # Bundle file v0.3
//   CAMERAS POINTS
//   for each camera:  f k1 k2, R (three rows), t
//   for each point:   its position, its colour, then N (CAMERA KEY X Y) of its N observations
//   P = R X + t,  p = -P / P.z,  pixel = f (1 + k1 |p|² + k2 |p|⁴) p
// The camera looks along -z with y up, and pixels count from the middle of the image with y up; ours looks
// along z with y down, and pixels count from the top left corner. World coordinates are unchanged, their unit
// is arbitrary. The principal point is the middle of the image, whose size its file says.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// `images`: the folder of the photographs, else empty: where their list says, or beside it. The list is
// NAME.list.txt, list.txt or list.focal.txt in the folder of `bundle_out` or in its parent; a row is "NAME [0
// FOCAL]". Cameras that were not registered (f is 0), and those without a photograph, are left out with a
// word in `doubts`. Throws Error that names file and line for an invalid file, counts that its content
// belies, and a list of another length.
PosedSet ReadBundlerSet(const std::filesystem::path& bundle_out, const std::filesystem::path& images);

}  // namespace ulf
