// The XMP files that RealityScan (once RealityCapture) exports: NAME.xmp for the photograph NAME.jpg.
//
// After "On the Coordinate Systems Employed in the Import, Estimation, and Export of Camera Geometry by
// RealityScan" (M. Hornáček, 8 June 2026, linked from dev.epicgames.com, "Camera Geometry in RealityScan"),
// equations 27 to 48 and appendix B. In an rdf:Description, each as an attribute or as an element:
//   xcr:Rotation                R of camera from world, row by row; xcr:Position: the camera's centre C
//   xcr:FocalLength35mm         f / s = it / 36 with s = max(w, h), in pixels
//   xcr:PrincipalPointU, V      (principal point - (w/2, h/2)) / s; missing: 0
//   xcr:DistortionModel         none (if missing), perspective, division, brown3, brown4, brown3t2, brown4t2
//   xcr:DistortionCoeficients   k1 k2 k3 k4 t1 t2 (their spelling), missing: none
// With X_cam = R (X - C), axes as ours, x = X_cam/Z_cam, y = Y_cam/Z_cam and r² = x² + y²:
//   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + t1 (r² + 2x²) + 2 t2 x y
//   y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + t2 (r² + 2y²) + 2 t1 x y
//   pixel = f (x', y') + principal point
// The coefficients belong to x and y, not to pixels, and "t1, t2 are OpenCV's t2, t1": t1 is p2, t2 is p1.
// (As printed, equation 48 has the two of y' the other way round, against that sentence; AliceVision and
// CAMORPH read them as here.) xcr:AspectRatio is fy / fx: the paper is silent, Epic's own writer (MetaHuman's
// DHInputOutput.cpp) has it so. Refused are skew, k4, a division other than 0, and models that are not
// listed.
//
// World coordinates are unchanged; whether they are metres is not said.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// `folder`: of the XMP files. `images`: of the photographs, else empty: the same, or images or photos in it,
// or its parent. Photographs without a pose are left out with a word in `doubts`, as are those of all
// components but the largest where positions are relative to a component. Throws Error that names file, value
// and way out.
PosedSet ReadRealityScanSet(const std::filesystem::path& folder, const std::filesystem::path& images);

}  // namespace ulf
