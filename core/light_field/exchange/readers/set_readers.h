// Readers of posed photographs by other programs, one for each format (set_format.h). Each comment describes
// the format and its conversion to a PosedSet. "Ours" means ulf's conventions: poses cam_from_world, x right,
// y down, z forward, pixel centres at integer + 0.5.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// Bundler's bundle.out (v0.3) with its list of photographs has cameras, points and their observations.
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

// `images` is the folder of the photographs; if empty, the one that the names in the list share, or images,
// photos or the folder itself where the list lies, or in its parent. The list is NAME.list.txt, list.txt,
// list.focal.txt, list.rd.txt or the only other one (NAME.list.txt or any .lst, as RealityCapture writes it),
// in the folder of `bundle_out` or in its parent; a row is "NAME [0 FOCAL]". Cameras that were not registered
// (f is 0), and those without a photograph, are left out and named in `doubts`. Throws an Error that names
// file and line for an invalid file, counts that disagree with its content, and a list of another length.
PosedSet ReadBundlerSet(const std::filesystem::path& bundle_out, const std::filesystem::path& images);

// A reconstruction by COLMAP is binary (which COLMAP itself prefers) or text, with points, their tracks, and
// COLMAP's masks (masks/NAME.png beside the images folder).

// `images` is the folder of the photographs; if empty, it is images, images_2, images_4, images_8, input or
// photos, beside or around the model, the only other folder there that holds photographs by the model's
// names, or the model's folder; those with its names come first. Views are numbered by the order of names.
// Poses are those of rigs and frames, if there are any. Of several models the one with the most images is
// read. `doubts` names the other models, photographs without a pose, poses without a photograph, and what was
// left out or normalised. Throws Error for a model that cannot be read, and if no photograph is found.
PosedSet ReadColmapSet(const std::filesystem::path& source, const std::filesystem::path& images);

// Returns how many images the model in the folder has, without reading its points.
std::uint64_t ImagesOfColmapModel(const std::filesystem::path& folder);
// Returns the cameras and poses of that model alone, in the order of names; no photograph need be there.
LightField ReadColmapSetPoses(const std::filesystem::path& source);

// Local Light Field Fusion (Mildenhall et al. 2019) has poses_bounds.npy and photographs in images, or
// reduced by N in images_N. The row of a photograph, in byte order of names, holds a 3x5 matrix, row by row,
// whose columns are down, right, back, centre and (height, width, focal length), then the nearest and the
// farthest depth. There is no lens distortion.

// `source` is the folder or the file. `images` is the folder of the photographs; if empty, the first with
// some among images, images_2, images_4, images_8, input and photos. Throws Error if the file is damaged, a
// row is no pose, or the numbers of photographs and rows differ.
PosedSet ReadLlffSet(const std::filesystem::path& source, const std::filesystem::path& images);

// Agisoft Metashape (once PhotoScan) exports its cameras by File > Export > Export Cameras, "Agisoft XML".
//
// The elements are document > chunk > sensors, components, cameras (also inside groups), transform. A
// camera's transform is chunk_from_cam, 16 numbers row by row, axes as ours. The transform of the camera's
// component, or else of the chunk, leads to the world: scale, rotation, translation. A geocentric translation
// (farther than 1e5 units) is left out, which `doubts` says: single precision resolves no millimetres there.
//
// The lens follows the manual 1.5, appendix "Camera models", with x = X/Z, y = Y/Z, r² = x² + y²:
//   frame:   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + (p1 (r² + 2x²) + 2 p2 x y) (1 + p3 r² + p4 r⁴)
//            y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + (p2 (r² + 2y²) + 2 p1 x y) (1 + p3 r² + p4 r⁴)
//            u = w/2 + cx + (f + b1) x' + b2 y',  v = h/2 + cy + f y'
//   fisheye: the same with x atan(r)/r and y atan(r)/r in place of x and y
// The centre of the first pixel is at (0.5, 0.5), as ours. p1 is OpenCV's p2, p2 its p1. Terms that our
// lenses lack (k4, p3, p4 and b2 of frame cameras, p1 to p4 and b2 of fisheyes) are left out if they move no
// pixel by more than 0.02 px; else a lens is fitted, whose distance `doubts` says, or refused if it is off by
// more than two pixels. All other sensors are refused.
//
// In a rig, a camera with a master_id and no transform of its own has its master's, times the place of its
// sensor: chunk_from_cam = chunk_from_master [R | l] with the sensor's <rotation> and <location>.

// `images` is the folder of the photographs; if empty, the first with some of them among images and photos
// beside the file, its folder, and that folder's parent. Photographs are found by the cameras' labels, which
// often lack the ending. The chunk with the most aligned cameras is read. Units are metres if the world is
// geocentric, or lies in a local coordinate system of metres and three known places of cameras or markers, or
// a scale bar, give its scale. Left out and named in `doubts` are cameras that were not aligned, are disabled
// or have no photograph; other chunks; and, if a component lacks a transform, all but the largest. points.ply
// beside the file is read if photographs show its points in the world or in the chunk's frame, and in one of
// them alone. Throws Error that names file, line and element for anything invalid or not supported.
PosedSet ReadMetashapeSet(const std::filesystem::path& xml, const std::filesystem::path& images);

// NeRF's synthetic scenes (Mildenhall et al. 2020) have transforms_train.json, transforms_val.json and
// transforms_test.json with one field of view, and pictures with alpha in train/, val/ and test/.

// Reads all views of the parts that exist, in this order, also those in two parts; photographs' paths begin
// with the part's folder. A part other than train whose photographs are all missing is left out.
// PosedSet::background is white. `images` and errors are as in ReadTransformsSet().
PosedSet ReadNerfSyntheticSet(const std::filesystem::path& folder, const std::filesystem::path& images = {});

// RealityScan (once RealityCapture) exports an XMP file NAME.xmp for the photograph NAME.jpg.
//
// The conventions follow "On the Coordinate Systems Employed in the Import, Estimation, and Export of Camera
// Geometry by RealityScan" (M. Hornáček, 8 June 2026, linked from dev.epicgames.com, "Camera Geometry in
// RealityScan"), equations 27 to 48 and appendix B. In an rdf:Description stand, as attributes or elements:
//   xcr:Rotation                R of camera from world, row by row; xcr:Position: the camera's centre C
//   xcr:FocalLength35mm         36 f / s with s = max(w, h), f and s in pixels
//   xcr:PrincipalPointU, V      (principal point - (w/2, h/2)) / s; missing: 0
//   xcr:DistortionModel         none (if missing), perspective, division, brown3, brown4, brown3t2, brown4t2
//   xcr:DistortionCoeficients   k1 k2 k3 k4 t1 t2 (their spelling), missing: none
// With X_cam = R (X - C), axes as ours, x = X_cam/Z_cam, y = Y_cam/Z_cam and r² = x² + y²:
//   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + t1 (r² + 2x²) + 2 t2 x y
//   y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) + t2 (r² + 2y²) + 2 t1 x y
//   pixel = f (x', y') + principal point
// The coefficients belong to x and y, not to pixels, and "t1, t2 are OpenCV's t2, t1": t1 is p2, t2 is p1.
// (As printed, equation 48 swaps the two of y', against that sentence; AliceVision and CAMORPH read them as
// here.) xcr:AspectRatio is fy / fx: the paper is silent, Epic's own writer (MetaHuman's DHInputOutput.cpp)
// has it so. Refused are skew, k4, a division other than 0, and models that are not listed.
//
// World coordinates are unchanged; the format does not say whether they are metres.

// `folder` has the XMP files. `images` has the photographs; if empty, the same folder, or images or photos in
// it. Photographs without a pose are left out and named in `doubts`, as are, if positions are relative to a
// component, all components but the largest. Throws an Error that names file, value and remedy.
PosedSet ReadRealityScanSet(const std::filesystem::path& folder, const std::filesystem::path& images);

// The TUM RGB-D benchmark (Sturm et al. 2012) has rgb.txt, a line `time file` for each photograph (seconds;
// the file relative to the folder), and beside it groundtruth.txt, a trajectory in TUM's format
// (core/geometry/trajectory.h; camera to world, metres). Each has its own times, by one clock. The layout has
// no intrinsics. Depth images (depth.txt) are not used.

// `rgb_txt` is the list; the trajectory lies beside it. `images` is the folder to which names are relative;
// if empty, the list's. `camera` is that of all photographs.
//
// Poses are found and errors thrown as AddTimedViews() does (timed_views.h); an invalid line is an Error that
// names file and line.
PosedSet ReadTumSet(const std::filesystem::path& rgb_txt, const std::filesystem::path& images,
                    const CameraModel& camera);

// The readers from here on find photographs by FoldersOfNames() (named_views.h) if `images` is empty. They
// leave out and name in `doubts` what has no pose and what has no photograph, and throw an Error that names
// file, place and remedy if more photographs are missing than found, for damage, and for a lens that neither
// is one of ours nor can be fitted (fitted_lens.h).

// EuRoC MAV (Burri et al. 2016, "The EuRoC micro aerial vehicle datasets"), also TUM VI, has mav0/ with
// cam0/sensor.yaml (pinhole; intrinsics f_u f_v c_u c_v and distortion coefficients as Kalibr's, so the
// centre of the first pixel is at (0, 0): 0.5 is added), cam0/data.csv (timestamp in ns, file in cam0/data)
// and state_groundtruth_estimate0/data.csv or mocap0/data.csv: timestamp, position p and quaternion q (w x y
// z) of a sensor S in the reference frame R. T_BS of each sensor.yaml leads from the sensor to the body B,
// hence world_from_cam = (p, q) T_BS(truth)^-1 T_BS(cam0). Times are by one clock, units metres.

// `mav0` is that folder; poses are found as in AddTimedViews(). cam1 is not used.
PosedSet ReadEurocSet(const std::filesystem::path& mav0, const std::filesystem::path& images);

// Inria's gaussian-splatting (Kerbl et al. 2023) writes cameras.json beside what it trains (camera_to_JSON()
// in utils/camera_utils.py): a list of img_name (often without its ending), width and height, fx and fy in
// pixels, "position", the camera's centre, and "rotation", world_from_cam, row by row, axes as COLMAP's and
// ours. The format has no principal point, it is the middle, and no distortion. World coordinates are those
// of the set it was trained on.

// `cameras_json` is that file. Photographs are first looked for where cfg_args beside it says that the
// program found them (source_path, images). input.ply beside it has points.
PosedSet ReadGaussianSplattingSet(const std::filesystem::path& cameras_json,
                                  const std::filesystem::path& images);

// The KITTI odometry benchmark (Geiger et al. 2012; readme of its development kit) has, for a sequence,
// image_0 to image_3 (rectified, 000000.png and so on), calib.txt with P0 to P3, the 3x4 projections from the
// first camera's frame to pixels of each, and a line of poses for each frame: 3x4, row by row, from the frame
// of the first camera to the world, which is that of frame 0 (x right, y down, z forward; metres). The centre
// of the first pixel is read as being at (0, 0), as OpenCV's; the readme does not say.

// `folder` has calib.txt. Poses are poses.txt in it or NN.txt of sequence NN in poses/ there or two folders
// above. Photographs are those in image_2 (left, colour) or else image_0 (left, grey); with `images` another
// of the four is read. times.txt gives times.
PosedSet ReadKittiSet(const std::filesystem::path& folder, const std::filesystem::path& images);

// Meshroom (AliceVision) has cameras.sfm, or a .sfm or .json of its node ConvertSfMFormat: views, intrinsics,
// poses, rigs and structure, with all numbers as text (sfmDataIO/jsonIO.cpp, file versions 1.0 to 1.2.14).
// "rotation" of a pose is cam_from_world, column by column, "center" the camera's centre; axes as ours. In a
// rig, cam_from_world = subPose * pose (SfMData::getPose).
//
// Focal lengths (IntrinsicScaleOffset.cpp), with w the width in pixels and s the sensor's width in mm:
//   before 1.2.0   pxFocalLength, one number            before 1.2.2   pxFocalLength, two numbers
//   before 1.2.5   f_x = focalLength w / s, f_y = f_x / pixelRatio
//   before 1.2.11  f_x = focalLength w / s, f_y = f_x pixelRatio
//   since 1.2.11   f_y = focalLength w / s, f_x = f_y / pixelRatio, with the larger side for w
// "principalPoint" counts from the middle of the picture, before 1.2.1 from its corner; the centre of the
// first pixel is at (0, 0) (cameraUndistortImage.hpp samples there): 0.5 is added. The distortions radialk1,
// radialk3, brown (t1, t2 are OpenCV's p1, p2) and fisheye (OpenCV's) are exact, as are equidistant cameras
// with none or radialk3pt, whose radius counts in parts of "fisheyeCircleRadius" (Equidistant.cpp); fisheye1
// (Devernay and Faugeras 2001) is fitted; others, and undistortions of 3DEqualizer, are refused.

// `file` is the .sfm or .json.
PosedSet ReadMeshroomSet(const std::filesystem::path& file, const std::filesystem::path& images);

// openMVG's sfm_data.json (sfm/sfm_data_io_cereal.cpp, versions 0.1 to 0.3) has root_path, views, intrinsics,
// extrinsics and structure. "rotation" is cam_from_world, row by row, "center" the camera's centre; axes as
// ours. The centre of the first pixel is at (0, 0) (cameras/Camera_undistort_image.hpp): 0.5 is added to
// principal_point and observations. pinhole, pinhole_radial_k1, pinhole_radial_k3, pinhole_brown_t2 (its t1,
// t2 are OpenCV's p1, p2) and fisheye (OpenCV's) are exact; spherical cameras are refused.

// `file` is the .json; those without extrinsics, as of openMVG's first step, are an Error.
PosedSet ReadOpenMvgSet(const std::filesystem::path& file, const std::filesystem::path& images);

// OpenSfM's reconstruction.json (doc/source/geometry.rst, opensfm/io.py), also OpenDroneMap's, is a list of
// reconstructions with cameras, shots and points. "rotation" (angle times axis) and "translation" of a shot
// are cam_from_world; axes as ours. Image coordinates count from the middle of the picture in units of its
// larger side: f_x = max(w, h) focal, c_x = w / 2 + max(w, h) c_x. The types perspective, simple_radial,
// radial, brown, fisheye and fisheye_opencv are exact; fisheye62 and fisheye624 are fitted; dual and
// spherical are refused.

// `file` is the .json. The reconstruction with the most shots is read, and the others are named.
PosedSet ReadOpenSfmSet(const std::filesystem::path& file, const std::filesystem::path& images);

// Polycam's raw data (github.com/PolyCam/polyform, "Polycam's data format") have keyframes/ with
// corrected_cameras and corrected_images, undistorted and with poses found together, or else cameras and
// images of ARKit. TIME.json has fx, fy, cx, cy from the picture's corner, width, height, and t_00 to t_23,
// three rows of world_from_cam with OpenGL's axes (x right, y up, z back). In the world y is up; units are
// metres. Corrected photographs have a black rim of some pixels.

// `cameras` is corrected_cameras or cameras. Depth maps and the mesh (of another world) are not used.
PosedSet ReadPolycamSet(const std::filesystem::path& cameras, const std::filesystem::path& images);

// RealityScan's (RealityCapture's) csv "Internal/External camera parameters" has a row for each photograph:
// #name, x, y, alt, heading, pitch, roll (degrees), f (mm of a film of 36 mm), px, py, k1 to k4, t1, t2. As
// nerfstudio (process_data/realitycapture_utils.py) and Brush read it, world_from_cam = Rz(-heading)
// Rx(pitch) Ry(roll) for OpenGL's axes: with all three 0 the camera looks down, its top to the north (y). f,
// px and py count in parts of the larger side, the principal point from the middle. The distortion is that of
// the XMP files above; k4 is fitted.

// `csv` is that file. Columns may be in any order; those of the lens may be missing.
PosedSet ReadRealityScanCsv(const std::filesystem::path& csv, const std::filesystem::path& images);

// VisualSFM's NVM_V3 (ccwu.me/vsfm/doc.html; LoadNVM() of its Multicore Bundle Adjustment) has models, each
// with a count and rows "NAME f q_w q_x q_y q_z C_x C_y C_z r 0", then a count and rows of points, "x y z,
// colour, count, (CAMERA FEATURE x y)". q is cam_from_world, C the camera's centre, axes as ours; in
// NVM_V3_R9T the matrix and the translation stand there instead. The principal point is the middle of the
// picture, from which x and y count, but for "FixedK f_x c_x f_y c_y r" in the title. A measured point m (in
// units of f) belongs to the straight one (1 + r |m|^2) m, the inverse of our polynomial, which is fitted. A
// '"' in a name is a space.

// `nvm` is that file. The model with the most cameras is read.
PosedSet ReadVisualSfmSet(const std::filesystem::path& nvm, const std::filesystem::path& images);

}  // namespace ulf
