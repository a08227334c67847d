// A map on disk, so that a capture that goes on need not build it again. It is a cache: what it holds can be
// made from the recorded views, and a file that is damaged, of another version, or of other views is not
// read but made anew.
//
// Little-endian, the numbers as they are in memory:
//   8 bytes "ulfmap\0" and version, key (which views and poses it belongs to), keyframes, points,
//   and last a checksum of all before it (FNV-1a, 64 bits).
// Everything given is restored but what follows from it (rays, mean directions, descriptors of points) and
// the keyframes' images. Restored keyframes are pinned: the recorded views' poses are given and must not
// move.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

std::string MapToBytes(const Map& map, std::uint64_t key);

// Fills `map`, which is empty. Returns what is wrong with the bytes, or an empty string; then `map` is
// usable.
std::string MapFromBytes(std::string_view bytes, std::uint64_t key, const CameraModel& camera, Map& map);

}  // namespace ulf::tracking
