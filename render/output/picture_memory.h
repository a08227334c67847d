// Whether a picture fits into memory, asked before it is begun.
#pragma once

#include <cstdint>

#include "render/output/picture_files.h"

namespace ulf::render {

// What rendering and encoding a picture takes, about.
std::uint64_t MemoryForPicture(int width, int height, const PictureEncoding& encoding);

// Throws Error that says how much is needed and how much there is.
void RequireMemory(int width, int height, const PictureEncoding& encoding, std::uint64_t available);

}  // namespace ulf::render
