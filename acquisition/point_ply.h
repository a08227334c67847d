// The tracked points as points.ply: binary little-endian, x y z float, red green blue uchar.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/light_field.h"

namespace ulf {

std::string PointPlyBytes(const std::vector<ScenePoint>& points);
// Throws Error when FILE is not a PLY of the kind above.
std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file);

}  // namespace ulf
