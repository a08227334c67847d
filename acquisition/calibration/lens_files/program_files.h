// Reads lens files of programs whose names and forms are their own. `read` takes the file's first document
// and throws Error that begins with `where`; `wanted` selects one of several cameras (PickLens()).
//
// Gyroflow, okvis, Kalibr, EuRoC, maplab, ORB-SLAM, VINS, Basalt and calib.io have pixel centres at integers.
// Metashape counts the principal point from the picture's middle and has pixel centres at integer + 0.5; its
// p1 and p2 are in the other order than OpenCV's, and fx is f + b1.
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
