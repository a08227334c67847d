// Reads and writes OpenEXR files. Pixels are linear light of any range; channels have names: R G B A, Z for
// depth, and "layer.channel" in layers (OpenEXR's "Technical Introduction", layers and channel names).
#pragma once

#include <array>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image/files/stored_picture.h"

namespace ulf {

enum class ExrCompression { kZip, kPiz };  // both are lossless

struct ExrChannel {
  std::string name;
  cv::Mat pixels;   // CV_16F or CV_32F, one or more channels; shared, not copied
  int channel = 0;  // index of the channel in `pixels`
};

// CIE x and y of red, green, blue and white (the attribute chromaticities). None means that the file makes
// no claim, as for a sensor's own colours.
using ExrColors = std::optional<std::array<float, 8>>;
inline constexpr std::array<float, 8> kRec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

// Returns the file's bytes; there is at least one channel, and all have one size. For kRec709 the header also
// names the colours: colorInteropID "lin_rec709_scene" (Academy Software Foundation, "Color Interop Forum:
// texture asset color spaces"). `attributes` are texts for the header by name, `numbers` floats. Throws
// Error if OpenEXR fails.
std::string ExrBytes(const std::vector<ExrChannel>& channels, ExrCompression compression,
                     const ExrColors& colors = {}, const std::map<std::string, std::string>& attributes = {},
                     const std::map<std::string, float>& numbers = {});
// Returns the chromaticities in the header, if there are any. Throws Error as ReadExr() does.
ExrColors ExrColorsOf(const std::string& path);
// Returns a text attribute, or "" if there is none of this name. Throws Error as ReadExr() does.
std::string ExrAttribute(const std::string& path, const std::string& name);

// Returns the display window as CV_32FC3 (B, G, R) from the channels R, G and B, or from Y, or from luminance
// and chroma (Y, RY, BY). Among several parts and layers a final picture's name (beauty, rgba, ...) comes
// first, then colour, then luminance; the first of equals is taken, with a warning. Colours are converted to
// sRGB's primaries from the header's. Infinities and NaN stay as they are. Throws Error naming the file if it
// is truncated, no EXR, a panorama, or without such channels in floating point.
StoredPicture ReadExrPicture(const std::string& path);
cv::Mat ReadExr(const std::string& path);   // StoredPicture::pixels of ReadExrPicture()
bool HasExrAlpha(const std::string& path);  // whether the picture has alpha, too; throws as ReadExr()

// Returns the data window of one channel of the first part as CV_32FC1; empty if there is none of this name.
// Throws as ReadExr() does.
cv::Mat ReadExrChannel(const std::string& path, const std::string& name);

// Converts CV_32F to CV_16F. Numbers beyond the range of half floats become the largest one.
cv::Mat HalfFromFloat(const cv::Mat& pixels);

}  // namespace ulf
