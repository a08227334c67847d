#include "core/image/over_background.h"

#include <opencv2/imgcodecs.hpp>

#include "core/image/image.h"
#include "core/image/image_header.h"

namespace ulf {

cv::Mat ReadOverBackground(const std::string& path, const cv::Vec3d& background) {
  const auto header = ReadImageHeader(path);
  if (!header || !header->alpha) return {};
  ReadImageFile(path);  // refuses what is damaged
  cv::Mat pixels = cv::imread(path, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  if (pixels.channels() != 4) return {};
  const int depth = pixels.depth();
  const double full = FullScale(depth);
  pixels.convertTo(pixels, CV_64F);
  cv::Mat over(pixels.size(), CV_64FC3);
  for (int y = 0; y < pixels.rows; ++y)
    for (int x = 0; x < pixels.cols; ++x) {
      const auto& from = pixels.at<cv::Vec4d>(y, x);
      const double opaque = from[3] / full;
      auto& to = over.at<cv::Vec3d>(y, x);
      for (int c = 0; c < 3; ++c) to[c] = opaque * from[c] + (1 - opaque) * full * background[c];
    }
  over.convertTo(over, depth);
  return over;
}

}  // namespace ulf
