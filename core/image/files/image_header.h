// The size and format of a PNG, JPEG or TIFF file from its header, without decoding (ISO 15948, ITU T.81,
// TIFF 6.0): checks a folder of a thousand photographs in milliseconds, and says what decoding would take.
#pragma once

#include <array>
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

// None for other kinds of files and for truncated headers.
std::optional<ImageHeader> ReadImageHeader(const std::string& path);
std::optional<ImageHeader> ReadImageHeader(std::istream& file);

// Throws Error, which begins with `path`, where decoded pixels would take more memory than a file of
// `file_bytes` can stand for: what is damaged, or made to take all memory, is refused before it takes any.
void RequirePixelsOfFile(const std::string& path, std::uint64_t file_bytes, double pixels,
                         double bytes_of_pixel);

// The size that pictures of the rarer kinds claim: BMP, Netpbm (PBM to PPM, PFM), Radiance HDR and WebP.
// ReadImageHeader() says more of the common ones.

// As the file says, unchecked; none: another kind, or truncated.
std::optional<cv::Size2d> ClaimedSize(std::istream& file);

}  // namespace ulf
