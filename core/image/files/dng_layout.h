// Reads how a DNG (Adobe's specification 1.7) arranges its pixels, for layouts that LibRaw 0.20 silently
// misreads: mosaics other than 2x2 and X-Trans, staggered mosaics, and tiles without compression.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ulf {

struct DngLayout {
  cv::Size mosaic;      // period in pixels; empty if every pixel has all colours
  std::string pattern;  // colours by rows: R, G, B, or C, M, Y, W; empty if not stated
  // Black levels by rows, columns and colours, repeated over a picture whose pixels have all colours.
  cv::Size black_period;
  std::vector<double> black;
  bool is_staggered = false;     // rows or columns of the mosaic are shifted by half a pixel
  bool has_plain_tiles = false;  // without compression
};

// Returns `count` bytes from a place; fewer if the file ends.
using ReadBytesAt = std::function<std::string(std::uint64_t at, std::size_t count)>;
// Returns whether LibRaw reads this mosaic correctly: the four orders of Bayer's, and X-Trans from any of
// its pixels.
bool IsKnownMosaic(const DngLayout& layout);
// Returns none if it is no DNG, or one without a raw picture.
std::optional<DngLayout> DngLayoutOf(const ReadBytesAt& read);

// Returns the DNG with its raw picture in one strip instead of uncompressed tiles. Throws Error, which
// begins with `name`, if the tiles reach beyond the file.
std::string DngWithoutTiles(const std::string& dng, const std::string& name);

}  // namespace ulf
