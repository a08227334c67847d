// How a DNG (Adobe's specification 1.7) lays its pixels out, as far as LibRaw 0.20 takes another layout for
// one that it knows and says nothing: mosaics other than 2x2 and X-Trans, staggered mosaics, and tiles
// without compression.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ulf {

struct DngLayout {
  cv::Size mosaic;      // its period in pixels; empty: every pixel has all colours
  std::string pattern;  // its colours by rows: R, G, B, and others as C, M, Y, W; empty: not said
  // Of a picture whose pixels have all colours: black levels by rows, columns and colours, repeated over the
  // picture.
  cv::Size black_period;
  std::vector<double> black;
  bool is_staggered = false;     // rows or columns of the mosaic are shifted by half a pixel
  bool has_plain_tiles = false;  // without compression
};

// The bytes from a place; fewer where the file ends.
using ReadBytesAt = std::function<std::string(std::uint64_t at, std::size_t count)>;
// Whether it is a mosaic that LibRaw takes for what it is: the four orders of Bayer's, and X-Trans from any
// of its pixels.
bool IsKnownMosaic(const DngLayout& layout);
// None: no DNG, or one without a raw picture.
std::optional<DngLayout> DngLayoutOf(const ReadBytesAt& read);

// The same DNG with its raw picture in one strip in place of uncompressed tiles. Throws Error, which begins
// with `name`, where the tiles reach beyond the file.
std::string DngWithoutTiles(const std::string& dng, const std::string& name);

}  // namespace ulf
