#include "render/quality/error_shares.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ulf::render {
namespace {

// CV_8U, 255 near jumps of depth.
cv::Mat DepthEdges(const cv::Mat& depth, const ErrorShareOptions& options) {
  const cv::Mat inverse = 1 / depth;
  const int side = 2 * options.edge_px + 1;
  const cv::Mat around = cv::Mat::ones(side, side, CV_8U);
  cv::Mat most, least;
  cv::dilate(inverse, most, around);
  cv::erode(inverse, least, around);
  return most - least > options.jump * most;
}

// CV_8U, 255 where the photograph has texture.
cv::Mat Texture(const cv::Mat& photograph, const ErrorShareOptions& options) {
  cv::Mat grey, mean, mean_square;
  cv::cvtColor(photograph, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_32F);
  cv::blur(grey, mean, {5, 5});
  cv::blur(grey.mul(grey), mean_square, {5, 5});
  return mean_square - mean.mul(mean) > options.texture_grey * options.texture_grey;
}

}  // namespace

ErrorShares ShareErrors(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid,
                        const cv::Mat& depth, const cv::Mat& confidence, const ErrorShareOptions& options) {
  const cv::Mat edges = DepthEdges(depth, options), texture = Texture(photograph, options);
  ErrorShares shares;
  std::vector<double> errors;
  double all = 0;
  for (int y = 0; y < rendered.rows; ++y)
    for (int x = 0; x < rendered.cols; ++x) {
      if (!valid.at<std::uint8_t>(y, x)) continue;
      const cv::Vec3d off =
          cv::Vec3d(rendered.at<cv::Vec3b>(y, x)) - cv::Vec3d(photograph.at<cv::Vec3b>(y, x));
      const double error = off.dot(off);
      const ErrorKind kind = confidence.at<float>(y, x) <= 0  ? ErrorKind::kUnseen
                             : edges.at<std::uint8_t>(y, x)   ? ErrorKind::kEdge
                             : texture.at<std::uint8_t>(y, x) ? ErrorKind::kTextured
                                                              : ErrorKind::kPlain;
      shares.of_error[static_cast<std::size_t>(kind)] += error;
      shares.of_pixels[static_cast<std::size_t>(kind)] += 1;
      errors.push_back(error);
      all += error;
    }
  if (errors.empty()) return shares;
  const std::size_t worst = std::max<std::size_t>(1, errors.size() / 100);
  std::nth_element(errors.begin(), errors.end() - static_cast<std::ptrdiff_t>(worst), errors.end());
  for (std::size_t i = errors.size() - worst; i < errors.size(); ++i) shares.of_worst_hundredth += errors[i];
  for (double& share : shares.of_pixels) share /= static_cast<double>(errors.size());
  if (!(all > 0)) return shares;
  for (double& share : shares.of_error) share /= all;
  shares.of_worst_hundredth /= all;
  return shares;
}

}  // namespace ulf::render
