// Reads the size and format of a PNG, JPEG or TIFF file from its header, without decoding (ISO 15948, ITU
// T.81, TIFF 6.0 and BigTIFF): a thousand photographs take milliseconds.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace ulf {

struct ImageHeader {
  std::string kind;        // "PNG", "JPEG" or "TIFF"
  std::int64_t width = 0;  // as the file says, unchecked
  std::int64_t height = 0;
  int channels = 0;    // with an alpha channel; 3 for a palette
  int bits = 0;        // per channel; 8 for a PNG of fewer
  bool alpha = false;  // an alpha channel, or transparent colours (tRNS) of a PNG
  bool is_float = false;

  bool operator==(const ImageHeader&) const = default;
  std::string Text() const;  // "JPEG 640x480, 3 channels of 8 bits"
};

// These return none for other kinds of files and for truncated headers; by path also for a missing file and
// for a camera's raw file, which may be a TIFF. A stream must be seekable.
std::optional<ImageHeader> ReadImageHeader(const std::string& path);
std::optional<ImageHeader> ReadImageHeader(std::istream& file);

// Refuses damaged or malicious files before memory is allocated: throws an Error that begins with `path` if
// the decoded pixels (`pixels` times `bytes_of_pixel`) need more memory than a file of `file_bytes` can
// expand to. Up to 256 MB always pass.
void RequirePixelsOfFile(const std::string& path, std::uint64_t file_bytes, double pixels,
                         double bytes_of_pixel);

// Returns the size that the header of a BMP, Netpbm (PBM to PPM, PFM), Radiance HDR or WebP file claims; none
// for other kinds and truncated headers. The size is unchecked, and may be huge, 0 or negative.
std::optional<cv::Size2d> ClaimedSize(std::istream& file);

}  // namespace ulf
