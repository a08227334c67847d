// Stores a map on disk, so that a resumed capture need not build it again. The file is a cache: if it is
// damaged, of another version, or of other views, the map is made anew from the recorded views.
//
// Little-endian, numbers as they are in memory:
//   8 bytes     "ulfmap\0" and version
//   8 bytes     key: the views and poses that it belongs to
//   keyframes
//   points
//   8 bytes     checksum of everything before it (FNV-1a, 64 bits)
// The file holds the main part's points, no keyframe images, and nothing that follows from the rest (rays,
// mean directions, descriptors of points). Restored keyframes are pinned: recorded views must not move.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/geometry/camera_model.h"
#include "tracking/map/anchored.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

std::string MapToBytes(const Map& map, std::uint64_t key);

// Fills `map`, which is empty. Returns none, or why the bytes cannot be used: then drop `map`.
std::optional<MapRefusal> MapFromBytes(std::string_view bytes, std::uint64_t key, const CameraModel& camera,
                                       Map& map);

}  // namespace ulf::tracking
