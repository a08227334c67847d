// Reads and writes a light field's points: points.ulf with observations, and points.ply with positions for
// other programs, which is derived from it.
#pragma once

#include <filesystem>

#include "core/light_field/light_field.h"

namespace ulf {

// Reads points.ulf; if it is missing or damaged, the positions in points.ply. Problems are added to
// light_field.doubts.
void ReadPoints(LightField& light_field);

// Reads positions from a PLY file; false: there is none. A damaged file is not an error but adds a message to
// light_field.doubts, because a light field is usable without points.
bool ReadPointPositions(const std::filesystem::path& ply, LightField& light_field);

void WritePoints(const LightField& light_field);

}  // namespace ulf
