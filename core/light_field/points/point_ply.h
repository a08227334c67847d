// Reads and writes points as PLY. Written files are binary little-endian: x y z float, red green blue uchar.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

std::string PointPlyBytes(const std::vector<ScenePoint>& points);
// The vertices of any PLY, with their colours if any, without those that are not finite. Throws Error for a
// file that is no PLY or is truncated.
std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file);

}  // namespace ulf
