// The cameras that Agisoft Metashape (once PhotoScan) exports: File > Export > Export Cameras, "Agisoft XML".
//
// document > chunk > sensors, components, cameras (also inside groups), transform. A camera's transform is
// world_from_cam in the chunk's coordinates, 16 numbers row by row, axes as ours. The transform of the
// camera's component, else of the chunk, leads to the world: scale, rotation, translation. A geocentric
// translation (farther than 1e5 units) is left out: millions of metres leave no millimetres in single
// precision.
//
// Agisoft Metashape manual 1.5, appendix "Camera models", with x = X/Z, y = Y/Z, r² = x² + y²:
//   frame:   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + (p1 (r² + 2x²) + 2 p2 x y) (1 + p3 r² + p4 r⁴)
//            y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + (p2 (r² + 2y²) + 2 p1 x y) (1 + p3 r² + p4 r⁴)
//            u = w/2 + cx + (f + b1) x' + b2 y',  v = h/2 + cy + f y'
//   fisheye: the same with x atan(r)/r and y atan(r)/r in place of x and y
// The centre of the first pixel is at (0.5, 0.5), as ours. p1 is OpenCV's p2, p2 its p1. Frame cameras with
// k4, p3, p4 or b2, fisheye cameras with p1 to p4 or b2, and all other sensors are refused.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// `images`: the folder of the photographs, else empty: the first that holds some of images and photos beside
// the file, its folder, and that folder's parent. Photographs are found by the cameras' labels, which often
// lack the ending. The first chunk with aligned cameras is read; units are metres where a transform gives
// scale. Left out with a word in `doubts`: cameras that were not aligned, are disabled or have no photograph;
// other chunks; where a component lacks a transform, all but the largest. Throws Error that names file, line
// and element for anything invalid or not supported.
PosedSet ReadMetashapeSet(const std::filesystem::path& xml, const std::filesystem::path& images);

}  // namespace ulf
