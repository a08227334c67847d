// Points as PLY. Ours (points.ply) are binary little-endian, x y z float, red green blue uchar.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

std::string PointPlyBytes(const std::vector<ScenePoint>& points);
// The vertices of any PLY, with their colours where they have some; those that are not finite are left out.
// Throws Error for what is no PLY or is truncated.
std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file);

}  // namespace ulf
