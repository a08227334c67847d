#include "core/image/clipped.h"

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ulf {
namespace {

// Marks each marked pixel of a mosaic in its own colour.
cv::Mat ByColor(const cv::Mat& marked, Mosaic mosaic) {
  const int red_row = mosaic == Mosaic::kGbrg || mosaic == Mosaic::kBggr,
            red_column = mosaic == Mosaic::kGrbg || mosaic == Mosaic::kBggr;
  cv::Mat colors = cv::Mat::zeros(marked.size(), CV_8UC3);
  for (int y = 0; y < marked.rows; ++y)
    for (int x = 0; x < marked.cols; ++x)
      colors.at<cv::Vec3b>(y, x)[2 - (y + red_row) % 2 - (x + red_column) % 2] =
          marked.at<std::uint8_t>(y, x);
  return colors;
}

}  // namespace

cv::Mat ClippedAfterDemosaicing(const cv::Mat& clipped) {
  if (clipped.empty() || cv::countNonZero(clipped.reshape(1)) == 0) return {};
  constexpr int kReach = 3;  // px, support of OpenCV's edge-aware method and of LibRaw's nearest neighbours
  cv::Mat around;
  cv::dilate(clipped, around, cv::Mat::ones(kReach, kReach, CV_8UC1));
  return around;
}

cv::Mat AnyColor(const cv::Mat& mask) {
  if (mask.channels() == 1) return mask;
  cv::Mat any;
  cv::reduce(mask.reshape(1, static_cast<int>(mask.total())), any, 1, cv::REDUCE_MAX);
  return any.reshape(1, mask.rows);
}

cv::Mat InThreeColors(const cv::Mat& one) {
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>(3, one), three);
  return three;
}

cv::Mat ClippedColors(const Image& image, double from) {
  if (image.pixels.depth() != CV_8U && image.pixels.depth() != CV_16U) return {};
  const cv::Mat full = image.pixels >= cv::Scalar::all(from * FullScale(image.pixels.depth()));
  if (cv::countNonZero(full.reshape(1)) == 0) return {};
  if (image.mosaic != Mosaic::kNone) return ClippedAfterDemosaicing(ByColor(full, image.mosaic));
  return full.channels() == 1 ? InThreeColors(full) : full;
}

cv::Mat ClippedPixels(const Image& image) {
  const cv::Mat colors = ClippedColors(image);
  return colors.empty() ? colors : AnyColor(colors);
}

}  // namespace ulf
