// OpenEXR files: the one room of that library. Pictures in linear light of any range, with channels by name:
// R G B A, Z for depth, and in layers "layer.channel" (OpenEXR's "Technical Introduction", layers and channel
// names).
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

// The file for channels of one size, in Rec. 709 primaries.
std::string ExrBytes(const std::vector<ExrChannel>& channels, ExrCompression compression);

// CV_32FC3, B G R, of a file's R, G and B (or Y for grey), the display window; what the file holds of
// infinities and NaN is left as it is. Throws Error naming the file when it is truncated, is no EXR or holds
// no such channels.
cv::Mat ReadExr(const std::string& path);

// Floats as halves: what is beyond their range becomes the largest of them.
cv::Mat HalfFromFloat(const cv::Mat& pixels);

}  // namespace ulf
