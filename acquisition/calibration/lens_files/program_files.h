// Reads lens files of single programs, each with names and forms of its own. Each function takes the file's
// first document and throws Error that begins with `where`; `wanted` selects one of several cameras.
//
// Gyroflow, okvis, Kalibr, EuRoC, maplab, ORB-SLAM, VINS, Basalt and calib.io have pixel centres at integers.
// Metashape counts the principal point from the picture's middle, pixel centres at integer + 0.5, has p1 and
// p2 in the other order than OpenCV, and fx is f + b1.
#pragma once

#include <string>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// Gyroflow's lens profile holds OpenCV's fisheye, unless its distortion_model says otherwise; camera_model
// names the camera.
bool IsGyroflowLens(const LensNode& top);
Lens ReadGyroflowLens(const LensNode& top, const std::string& where, const std::string& wanted);

// okvis and okvis2 describe cameras by lists for focal length, principal point and size.
bool IsOkvisLens(const LensNode& top);
Lens ReadOkvisLens(const LensNode& top, const std::string& where, const std::string& wanted);

bool IsKalibrLens(const LensNode& top);
Lens ReadKalibrLens(const LensNode& top, const std::string& where, const std::string& wanted);

// EuRoC's sensor.yaml describes one camera as Kalibr does, at the top level.
bool IsEurocLens(const LensNode& top);
Lens ReadEurocLens(const LensNode& top, const std::string& where, const std::string& wanted);

// maplab and aslam_cv2 describe a camera, or the cameras of a rig: intrinsics of four numbers as a matrix,
// distortion with a type and parameters. Their "fisheye" is the field-of-view model.
bool IsMaplabLens(const LensNode& top);
Lens ReadMaplabLens(const LensNode& top, const std::string& where, const std::string& wanted);

// ORB-SLAM2 and 3 and stella_vslam have settings such as Camera.fx or Camera1.fx.
bool IsOrbSlamLens(const LensNode& top);
Lens ReadOrbSlamLens(const LensNode& top, const std::string& where, const std::string& wanted);

// VINS-Mono, VINS-Fusion and camodocal share a format.
bool IsVinsLens(const LensNode& top);
Lens ReadVinsLens(const LensNode& top, const std::string& where, const std::string& wanted);

bool IsBasaltLens(const LensNode& top);
Lens ReadBasaltLens(const LensNode& top, const std::string& where, const std::string& wanted);

bool IsCalibIoLens(const LensNode& top);
Lens ReadCalibIoLens(const LensNode& top, const std::string& where, const std::string& wanted);

bool IsMetashapeLens(const LensNode& top);
Lens ReadMetashapeLens(const LensNode& top, const std::string& where, const std::string& wanted);

}  // namespace ulf::acquisition
