// Reads lenses from files of whole sets of photographs with the readers of these sets: COLMAP's cameras.txt
// and nerfstudio's or instant-ngp's transforms.json.
#pragma once

#include <string>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// Returns whether the first row begins with a number and the name of a model in capitals.
bool IsColmapCameras(const std::string& text);
// Both readers throw Error that begins with `where`; `wanted` selects one of several lenses (PickLens()).
Lens ReadColmapLens(const std::string& text, const std::string& where, const std::string& wanted);

bool IsTransformsLens(const LensNode& top);
// Lenses that differ between frames are numbered from 1 in the file's order.
Lens ReadTransformsLens(const std::string& text, const std::string& where, const std::string& wanted);

}  // namespace ulf::acquisition
