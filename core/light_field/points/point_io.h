// Where a light field's points stand: points.ulf with what views show of them, and points.ply, the positions
// for other programs, which follows from it.
#pragma once

#include <filesystem>

#include "core/light_field/light_field.h"

namespace ulf {

// From points.ulf where that is there and whole, else from points.ply: positions alone. What is amiss is a
// word in light_field.doubts.
void ReadPoints(LightField& light_field);

// From a PLY alone; false where there is none. One that is damaged is a word in light_field.doubts: points
// are of use, and nothing that cannot be made again.
bool ReadPointPositions(const std::filesystem::path& ply, LightField& light_field);

void WritePoints(const LightField& light_field);

}  // namespace ulf
