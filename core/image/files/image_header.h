// Reads the size and format of a PNG, JPEG or TIFF file from its header, without decoding (ISO 15948, ITU
// T.81, TIFF 6.0): this checks a folder of a thousand photographs in milliseconds, and predicts the memory
// for decoding.
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
  int channels = 0;
  int bits = 0;        // per channel
  bool alpha = false;  // a channel of its own, or colours that are transparent
  bool is_float = false;

  bool operator==(const ImageHeader&) const = default;
  std::string Text() const;  // "JPEG 640x480, 3 channels of 8 bits"
};

// Returns none for other kinds of files and for truncated headers.
std::optional<ImageHeader> ReadImageHeader(const std::string& path);
std::optional<ImageHeader> ReadImageHeader(std::istream& file);

// Throws Error, which begins with `path`, if decoded pixels would need more memory than a file of
// `file_bytes` can justify, so that damaged or malicious files are refused before memory is allocated.
void RequirePixelsOfFile(const std::string& path, std::uint64_t file_bytes, double pixels,
                         double bytes_of_pixel);

// Reads the size that pictures of rarer kinds claim: BMP, Netpbm (PBM to PPM, PFM), Radiance HDR and WebP.
// ReadImageHeader() says more of the common ones.

// The size is unchecked; none means another kind, or a truncated file.
std::optional<cv::Size2d> ClaimedSize(std::istream& file);

}  // namespace ulf
