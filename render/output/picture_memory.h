// Whether a picture fits into memory, checked before rendering.
#pragma once

#include <cstdint>

#include "render/output/picture_files.h"

namespace ulf::render {

// The bytes that rendering and encoding a picture take, estimated.
std::uint64_t MemoryForPicture(int width, int height, const PictureEncoding& encoding);

// Throws Error that says how much memory is needed and how much is available.
void RequireMemory(int width, int height, const PictureEncoding& encoding, std::uint64_t available);

}  // namespace ulf::render
