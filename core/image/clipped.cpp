#include "core/image/clipped.h"

#include <opencv2/imgproc.hpp>

namespace ulf {

cv::Mat ClippedAfterDemosaicing(const cv::Mat& clipped) {
  if (clipped.empty() || cv::countNonZero(clipped) == 0) return {};
  constexpr int kReach =
      3;  // pixels across, of OpenCV's edge-aware method and of LibRaw's nearest neighbours
  cv::Mat around;
  cv::dilate(clipped, around, cv::Mat::ones(kReach, kReach, CV_8UC1));
  return around;
}

cv::Mat ClippedPixels(const Image& image) {
  if (image.pixels.depth() != CV_8U && image.pixels.depth() != CV_16U) return {};
  cv::Mat full = image.pixels >= cv::Scalar::all(kClippedFrom * FullScale(image.pixels.depth()));
  if (image.mosaic != Mosaic::kNone) return ClippedAfterDemosaicing(full);
  if (full.channels() > 1) {
    cv::Mat any;
    cv::reduce(full.reshape(1, static_cast<int>(full.total())), any, 1, cv::REDUCE_MAX);
    full = any.reshape(1, full.rows);
  }
  return cv::countNonZero(full) > 0 ? full : cv::Mat();
}

}  // namespace ulf
