// Reads and writes a light field's points: points.ulf with all their observations (docs/light_field.md
// describes it), and points.ply, which is derived from it, with their positions for other programs.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// Reads points.ulf of light_field.root; if it is missing or damaged, the positions in points.ply. Points that
// are observed by views whose pose or camera has changed since are computed again, because the journal's
// poses take precedence. All reprojection errors are measured, and misplaced observations removed
// (point_tracks.h). Problems are added to light_field.doubts; throws Error if points.ply cannot be read
// beside points.ulf.
void ReadPoints(LightField& light_field);

// Reads positions from a PLY file; returns false if there is no file. A damaged one only adds a message to
// light_field.doubts, because a light field is usable without points.
bool ReadPointPositions(const std::filesystem::path& ply, LightField& light_field);

// Writes both files in light_field.root. Throws DiskFullError, Error.
void WritePoints(const LightField& light_field);

// Returns the content of points.ulf.
std::string PointFileBytes(const LightField& light_field);

struct StoredPoints {
  std::string problem;             // why the bytes are no valid points.ulf; empty: the rest is set
  std::vector<ScenePoint> points;  // as stored, without errors
  std::set<int> moved;             // ids of views whose pose or camera has changed
};
StoredPoints PointsFromBytes(std::string_view bytes, const LightField& light_field);

// Returns a PLY file, binary little-endian: x y z float, red green blue uchar. `light_field` is a mark that
// identifies the light field whose points they are; empty for a separate file.
std::string PointPlyBytes(const std::vector<ScenePoint>& points, const std::string& light_field = "");
// Returns the finite vertices of any PLY, with colours if any. Throws Error if it is no PLY or truncated.
std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file);

}  // namespace ulf
