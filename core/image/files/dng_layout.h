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
  std::string pattern;  // colours of a period by rows, letters of RGBCMYW, ? for others; empty if not stated
  // Only for a picture whose pixels have all colours: the size of the pattern of black levels, in pixels, and
  // its levels by rows, columns and colours.
  cv::Size black_period;
  std::vector<double> black;
  bool is_staggered = false;     // rows or columns of the mosaic are shifted by half a pixel
  bool has_plain_tiles = false;  // without compression
};

// Returns `count` bytes of a file from the position `at` on; fewer if it ends.
using ReadBytesAt = std::function<std::string(std::uint64_t at, std::size_t count)>;
// Returns whether LibRaw reads this mosaic correctly: none, Bayer's four orders, and X-Trans in any shift.
bool IsKnownMosaic(const DngLayout& layout);
// Returns none if the file is no DNG, or has no raw picture.
std::optional<DngLayout> DngLayoutOf(const ReadBytesAt& read);

// Returns the DNG with its raw picture in one strip instead of uncompressed tiles. Throws an Error that
// begins with `name` if the tiles reach beyond the file, if colours are in separate planes, or above 4 GB.
std::string DngWithoutTiles(const std::string& dng, const std::string& name);

}  // namespace ulf
