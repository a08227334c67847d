#include "core/image/files/over_background.h"

#include <opencv2/imgproc.hpp>

#include "core/image/files/picture_file.h"
#include "core/image/image.h"

namespace ulf {

cv::Mat ReadOverBackground(const std::string& path, const cv::Vec3d& background) {
  if (!HasAlphaChannel(path)) return {};
  const StoredPicture picture = ReadPicture(path);
  if (picture.alpha.empty()) return {};
  const int depth = picture.pixels.depth();
  const double full = FullScale(depth);
  cv::Mat colors = picture.pixels, alpha;
  if (colors.channels() == 1) cv::cvtColor(picture.pixels, colors, cv::COLOR_GRAY2BGR);
  colors.convertTo(colors, CV_64F);
  picture.alpha.convertTo(alpha, CV_64F, 1 / full);
  cv::Mat over(colors.size(), CV_64FC3);
  for (int y = 0; y < colors.rows; ++y)
    for (int x = 0; x < colors.cols; ++x) {
      const auto& from = colors.at<cv::Vec3d>(y, x);
      const double opaque = alpha.at<double>(y, x);
      auto& to = over.at<cv::Vec3d>(y, x);
      for (int c = 0; c < 3; ++c) to[c] = opaque * from[c] + (1 - opaque) * full * background[c];
    }
  over.convertTo(over, depth);
  return over;
}

}  // namespace ulf
