// Reads lens files of single programs, each with names and forms of its own. `read` takes the file's first
// document and throws Error that begins with `where`; `wanted` selects one of several cameras.
//
// Gyroflow, okvis, Kalibr, EuRoC, maplab, ORB-SLAM, VINS, Basalt and calib.io have pixel centres at integers.
// Metashape counts the principal point from the picture's middle, pixel centres at integer + 0.5, has p1 and
// p2 in the other order than OpenCV, and fx is f + b1.
#pragma once

#include <span>
#include <string>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

struct LensProgram {
  const char* name;
  bool (*is)(const LensNode& top);  // whether it wrote the file
  Lens (*read)(const LensNode& top, const std::string& where, const std::string& wanted);
};

// Returns the programs in the order in which they are looked for.
std::span<const LensProgram> LensPrograms();

}  // namespace ulf::acquisition
