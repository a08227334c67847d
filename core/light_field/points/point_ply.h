// Reads and writes points as PLY. Written files are binary little-endian: x y z float, red green blue uchar.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// `light_field`: a mark of the light field whose points they are; empty: they are a file of their own.
std::string PointPlyBytes(const std::vector<ScenePoint>& points, const std::string& light_field = "");
// Whether the vertices of two files that were written so are the same, whatever their headers say.
bool HoldsSamePoints(std::string_view ply, std::string_view other);
// Whether ulf wrote the file for this light field and nobody changed it since, by mark and checksum in its header.
bool IsOwnPointPly(std::string_view ply, const std::string& light_field);
// The vertices of any PLY, with their colours if any, without those that are not finite. Throws Error for a
// file that is no PLY or is truncated.
std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file);

}  // namespace ulf
