// OpenEXR files. Pixels are linear light of any range; channels have names: R G B A, Z for depth, and
// "layer.channel" in layers (OpenEXR's "Technical Introduction", layers and channel names).
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ulf {

enum class ExrCompression { kZip, kPiz };

struct ExrChannel {
  std::string name;
  cv::Mat pixels;   // CV_16F or CV_32F, one or more channels; shared, not copied
  int channel = 0;  // of `pixels`
};

// The file's bytes; all channels have one size and Rec. 709 primaries. Throws Error.
std::string ExrBytes(const std::vector<ExrChannel>& channels, ExrCompression compression);

// The display window as CV_32FC3 (B, G, R) from the channels R, G and B, or from Y. Infinities and NaN stay
// as they are. Throws Error naming the file when it is truncated, is no EXR or has no such channels.
cv::Mat ReadExr(const std::string& path);

// CV_16F from CV_32F. Numbers beyond the range of half floats become the largest one.
cv::Mat HalfFromFloat(const cv::Mat& pixels);

}  // namespace ulf
