// Semi-global matching (Hirschmueller 2008) finds for each pixel the label with the least sum of its own cost
// and the costs of changes along eight directions.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ulf::render {

// The costs of all labels at each pixel; the labels of a pixel are adjacent in memory.
class CostVolume {
 public:
  CostVolume(int width, int height, int labels)
      : width_(width),
        height_(height),
        labels_(labels),
        stride_((labels + 15) / 16 * 16),
        costs_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * stride(), 255) {}
  // Returns the costs of the pixel's labels.
  std::uint8_t* At(int x, int y) { return costs_.data() + Offset(x, y); }
  const std::uint8_t* At(int x, int y) const { return costs_.data() + Offset(x, y); }
  int width() const { return width_; }
  int height() const { return height_; }
  int labels() const { return labels_; }
  std::size_t stride() const { return static_cast<std::size_t>(stride_); }  // labels and padding

 private:
  std::size_t Offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)) *
           stride();
  }
  int width_, height_, labels_, stride_;
  std::vector<std::uint8_t> costs_;
};

// Costs are in the volume's units.
struct SemiGlobalOptions {
  int small_step = 8;    // cost of a change by one label
  int large_step = 72;   // cost of a larger change at constant grey value
  float edge_grey = 12;  // a change of the grey value that halves the cost of a larger change
};

// Returns CV_32F labels, with fractions by a parabola through the costs of the pixel and its neighbours of
// about the same label (sums along paths favour whole labels). `grey` is the view's image, CV_32F.
cv::Mat SemiGlobalMinimum(const CostVolume& volume, const cv::Mat& grey, const SemiGlobalOptions& options);

}  // namespace ulf::render
