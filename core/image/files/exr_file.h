// OpenEXR files. Pixels are linear light of any range; channels have names: R G B A, Z for depth, and
// "layer.channel" in layers (OpenEXR's "Technical Introduction", layers and channel names).
#pragma once

#include <array>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image/files/stored_picture.h"

namespace ulf {

enum class ExrCompression { kZip, kPiz };

struct ExrChannel {
  std::string name;
  cv::Mat pixels;   // CV_16F or CV_32F, one or more channels; shared, not copied
  int channel = 0;  // of `pixels`
};

// CIE x and y of red, green, blue and white (the attribute chromaticities). None: the file makes no claim, as
// for a sensor's own colours.
using ExrColors = std::optional<std::array<float, 8>>;
inline constexpr std::array<float, 8> kRec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

// The file's bytes; all channels have one size. Of kRec709 colours the header has the name as well:
// colorInteropID "lin_rec709_scene" (Academy Software Foundation, "Color Interop Forum: texture asset color
// spaces"). `attributes`: texts for the header by name. Throws Error.
std::string ExrBytes(const std::vector<ExrChannel>& channels, ExrCompression compression,
                     const ExrColors& colors = {}, const std::map<std::string, std::string>& attributes = {});
// What a file claims of its colours. Throws Error as ReadExr() does.
ExrColors ExrColorsOf(const std::string& path);
// Such a text; empty where there is none of this name. Throws Error as ReadExr() does.
std::string ExrAttribute(const std::string& path, const std::string& name);

// The display window as CV_32FC3 (B, G, R) from the channels R, G and B, or from Y, or from luminance and
// chroma (Y, RY, BY); of the first part that has them, else of the one layer that has. Colours are converted
// to sRGB's primaries from those that the file claims. Infinities and NaN stay as they are. Throws Error
// naming the file when it is truncated, is no EXR or has no such channels.
StoredPicture ReadExrPicture(const std::string& path);
cv::Mat ReadExr(const std::string& path);   // its pixels
bool HasExrAlpha(const std::string& path);  // beside the channels that are read; throws as ReadExr()

// The data window of one channel as CV_32FC1; empty where the file has none of this name. Throws as
// ReadExr().
cv::Mat ReadExrChannel(const std::string& path, const std::string& name);

// CV_16F from CV_32F. Numbers beyond the range of half floats become the largest one.
cv::Mat HalfFromFloat(const cv::Mat& pixels);

}  // namespace ulf
