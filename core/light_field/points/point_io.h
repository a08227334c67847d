// Reads and writes a light field's points: points.ulf with all their observations, and points.ply, which is
// derived from it, with their positions for other programs.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// Reads points.ulf; if it is missing or damaged, the positions in points.ply. Problems are added to
// light_field.doubts.
void ReadPoints(LightField& light_field);

// Reads positions from a PLY file; returns false if there is none. A damaged file is not an error but adds a
// message to light_field.doubts, because a light field is usable without points.
bool ReadPointPositions(const std::filesystem::path& ply, LightField& light_field);

void WritePoints(const LightField& light_field);

// points.ulf holds the points with all their observations (docs/light_field.md, for other programs).
//
// The journal's poses take precedence: points that are observed by views whose pose or camera has changed
// since are computed again. Errors are not stored but computed. If the file is damaged or missing, points.ply
// has the positions.

std::string PointFileBytes(const LightField& light_field);

struct StoredPoints {
  std::string problem;             // empty if the bytes are valid and the rest is set
  std::vector<ScenePoint> points;  // as stored
  std::set<int> moved;             // ids of views whose pose or camera has changed
};
StoredPoints PointsFromBytes(std::string_view bytes, const LightField& light_field);

// Reads and writes points as PLY. Written files are binary little-endian: x y z float, red green blue uchar.

// `light_field` identifies the light field whose points they are; it is empty for a separate file.
std::string PointPlyBytes(const std::vector<ScenePoint>& points, const std::string& light_field = "");
// Returns the finite vertices of any PLY, with their colours if any. Throws Error for a file that is no PLY
// or is truncated.
std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file);

}  // namespace ulf
