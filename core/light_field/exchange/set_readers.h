// Readers of sets of posed photographs by other programs, one for each format (set_format.h): what each
// format says, and how it becomes a PosedSet.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

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

// `images`: the folder of the photographs, else empty: where their list says, or beside it. The list is
// NAME.list.txt, list.txt or list.focal.txt in the folder of `bundle_out` or in its parent; a row is "NAME [0
// FOCAL]". Cameras that were not registered (f is 0), and those without a photograph, are left out with a
// word in `doubts`. Throws Error that names file and line for an invalid file, counts that its content
// belies, and a list of another length.
PosedSet ReadBundlerSet(const std::filesystem::path& bundle_out, const std::filesystem::path& images);

// A reconstruction by COLMAP as a set of posed photographs: binary (which COLMAP itself prefers) or text,
// with points, their tracks, and masks as COLMAP has them (masks/NAME.png beside the images folder).

// `images`: the folder of the photographs; empty: images, images_2, images_4, images_8, input or photos,
// beside or around the model, or where the model lies. Views are numbered in the order of their names.
// Photographs without a pose, and poses without a photograph, are left out with a word; other numbered models
// beside the one that is read are named. Throws Error for a model that cannot be read, and where no
// photograph is found.
PosedSet ReadColmapSet(const std::filesystem::path& source, const std::filesystem::path& images);

// Sets in the format of Local Light Field Fusion (Mildenhall et al. 2019): poses_bounds.npy and photographs
// that lie in images, or reduced by N in images_N. The row of a photograph, in the order of names as
// computers sort them, holds a 3x5 matrix, row by row, whose columns are down, right, back, centre and
// (height, width, focal length), then the nearest and the farthest depth. There is no lens distortion.

// `source`: the folder, or the file. `images`: the folder of the photographs; empty: images, or else the
// largest of images_2, images_4, images_8. Throws Error where the file is damaged, a row is no pose, or the
// number of photographs is another one than that of the rows.
PosedSet ReadLlffSet(const std::filesystem::path& source, const std::filesystem::path& images);

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

// `images`: the folder of the photographs, else empty: the first that holds some of images and photos beside
// the file, its folder, and that folder's parent. Photographs are found by the cameras' labels, which often
// lack the ending. The first chunk with aligned cameras is read; units are metres where a transform gives
// scale. Left out with a word in `doubts`: cameras that were not aligned, are disabled or have no photograph;
// other chunks; where a component lacks a transform, all but the largest. Throws Error that names file, line
// and element for anything invalid or not supported.
PosedSet ReadMetashapeSet(const std::filesystem::path& xml, const std::filesystem::path& images);

// Sets in the format of NeRF's synthetic scenes (Mildenhall et al. 2020): transforms_train.json,
// transforms_val.json and transforms_test.json with one field of view and pictures with alpha in train/, val/
// and test/.

// All views of all parts that are there, in this order, twice what two parts name; the names of the
// photographs begin with the part's. `images` and errors as of ReadTransformsSet().
PosedSet ReadNerfSyntheticSet(const std::filesystem::path& folder, const std::filesystem::path& images = {});

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

// `folder`: of the XMP files. `images`: of the photographs, else empty: the same, or images or photos in it,
// or its parent. Photographs without a pose are left out with a word in `doubts`, as are those of all
// components but the largest where positions are relative to a component. Throws Error that names file, value
// and way out.
PosedSet ReadRealityScanSet(const std::filesystem::path& folder, const std::filesystem::path& images);

// Sets in the layout of the TUM RGB-D benchmark (Sturm et al. 2012): rgb.txt, a line `time file` for each
// photograph (seconds; the file counts from the folder), and beside it groundtruth.txt, a trajectory in TUM's
// format (core/geometry/trajectory.h; camera to world, metres). The two have times of their own, by one
// clock. The layout has no intrinsics. Depth images (depth.txt) are not used.

// `rgb_txt`: the list; the trajectory lies beside it. `images`: the folder from which the names count; empty:
// the list's. `camera`: of all photographs.
//
// A photograph's pose is interpolated between the poses before and after it, where these are at most 0.1 s
// apart; else it is the nearest one within 0.02 s (as the benchmark's associate.py takes it). Photographs
// without either, and those that are not there, are left out with a word in `doubts`. Views are in order of
// time, whatever the files' order. Throws Error that names file and line for a line that is none, a
// photograph that is named twice, and a name that leaves the folder; and Error with both ranges of time where
// no photograph has a pose.
PosedSet ReadTumSet(const std::filesystem::path& rgb_txt, const std::filesystem::path& images,
                    const CameraModel& camera);

}  // namespace ulf
