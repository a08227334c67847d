// Stores a photograph's pyramid in a file, so that any level can be read without decoding. The file is a
// cache: a program that cannot use it makes it again from the photograph.
//
// The file holds the pixels as they are in memory, coarsest level first, so that the coarse levels are one
// read from its beginning. A key, a digest by the caller, identifies what they were made from. Each level has
// a checksum, because the files are renamed into place but not synced: a power cut may leave anything.
// Numbers have the machine's byte order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "render/photographs/photograph.h"

namespace ulf::render {

// Counts pixels of a photograph when it is decoded.
struct PixelCounts {
  std::uint64_t gaps = 0;     // not finite
  std::uint64_t clipped = 0;  // core/image/clipped.h
  bool operator==(const PixelCounts&) const = default;
};

// Writes under a temporary name and renames: two programs may write one file. Throws DiskFullError or Error.
void WritePyramidFile(const std::filesystem::path& path, std::uint64_t key, const ViewPyramid& pyramid,
                      const PixelCounts& counts = {});

struct StoredLevel {
  cv::Mat pixels;
  PixelCounts counts = {};  // of the whole photograph
};
// Returns a level; none if the file is missing or damaged, or has another key, size or form of photograph.
std::optional<StoredLevel> ReadPyramidFile(const std::filesystem::path& path, std::uint64_t key,
                                           const Photograph& photograph, int level);

}  // namespace ulf::render
