// A photograph's pyramid as a file, so that any level of it is read without decoding anything: disposable,
// made from the photograph again whenever it does not fit.
//
// Pixels stand as they are in memory, the coarsest level first, so that a glance at a photograph is one read
// from the beginning of the file. A key says what they were made from, a checksum by level that they are what
// was written: such files are renamed into place but not synced, a cut of the power may leave anything.
// Numbers are the machine's own: the file is a cache of one computer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "render/scene/photograph.h"

namespace ulf::render {

// Not cryptographic; some GB/s.
std::uint64_t Checksum(std::string_view bytes, std::uint64_t seed = 0);

// `gap_px`: pixels of the photograph that are not finite. Under a temporary name (kTemporaryEnding) first:
// two programs may write the same file. Throws DiskFullError or Error.
void WritePyramidFile(const std::filesystem::path& path, std::uint64_t key, const ViewPyramid& pyramid,
                      std::uint64_t gap_px = 0);

struct StoredLevel {
  cv::Mat pixels;
  std::uint64_t gap_px = 0;
};
// Of the photograph's size and form; none where the file is missing, has another key, or is damaged.
std::optional<StoredLevel> ReadPyramidFile(const std::filesystem::path& path, std::uint64_t key,
                                           const Photograph& photograph, int level);

}  // namespace ulf::render
