// points.ulf: the points with all places where views show them. points.ply and sparse/0 follow from it.
// (docs/disk_format.md, for other programs.)
//
// Little-endian, the numbers as they are in memory:
//   8 bytes "ulfpts\0" and version
//   views: how many (u32), each its id (i32) and a digest of the pose and the camera that the points were
//     measured under (u64)
//   points: how many (u32), each x y z (f64), red green blue (u8), observations (u32), each the view's index
//     in the list above (u32) and x y in its image (f32, pixel centres at integer + 0.5)
//   a checksum of all before it (FNV-1a, 64 bits)
//
// The journal's poses win: what views show whose pose or camera has changed since is put where the poses have
// it now. Errors are not stored, they follow. A file that is damaged or missing leaves points.ply: positions.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

std::string PointFileBytes(const LightField& light_field);

struct StoredPoints {
  std::string problem;             // what is wrong with the bytes; empty: nothing, and the rest is set
  std::vector<ScenePoint> points;  // as they are stored
  std::set<int> moved;             // views that have other poses or cameras now
};
StoredPoints PointsFromBytes(std::string_view bytes, const LightField& light_field);

}  // namespace ulf
