#include "core/image/exposure_alignment.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace ulf {
namespace {

// A surface that is nearer than the pixel's by this share hides it. Guessed: geometry is wrong by less.
constexpr float kHiddenBy = 0.03f;

Eigen::Vector3d RayOf(const CameraModel& camera, int x, int y) {
  const auto ray = camera.RayFromImg({x + 0.5, y + 0.5});
  if (!ray)
    throw Error(
        "the lens's distortion cannot be inverted at pixel {},{}: correct the intrinsics (ulf calibrate)", x,
        y);
  return *ray / ray->z();
}

}  // namespace

cv::Mat DepthInPicture(const CameraModel& camera, const CameraModel& depth_camera, const cv::Mat& depth) {
  cv::Mat in_picture(camera.height, camera.width, CV_32FC1);
  for (int y = 0; y < in_picture.rows; ++y)
    for (int x = 0; x < in_picture.cols; ++x) {
      const auto img = depth_camera.ImgFromCam(RayOf(camera, x, y));
      const Eigen::Vector2d at = img.value_or(Eigen::Vector2d(depth_camera.cx, depth_camera.cy));
      in_picture.at<float>(y, x) =
          depth.at<float>(std::clamp(static_cast<int>(std::floor(at.y())), 0, depth.rows - 1),
                          std::clamp(static_cast<int>(std::floor(at.x())), 0, depth.cols - 1));
    }
  return in_picture;
}

AlignedExposure AlignExposure(const ExposedLight& exposure, const CameraModel& camera, const cv::Mat& depth,
                              const Rigid3& exposure_from_reference, double ratio) {
  cv::Mat where(depth.size(), CV_32FC2, cv::Scalar::all(-1e6));
  cv::Mat depths(depth.size(), CV_32FC1, cv::Scalar(0));  // in the exposure's image
  cv::Mat nearest(depth.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::max()));
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const Eigen::Vector3d point = exposure_from_reference * (depth.at<float>(y, x) * RayOf(camera, x, y));
      const auto img = camera.ImgFromCam(point);
      if (!img || !camera.Contains(*img)) continue;
      where.at<cv::Vec2f>(y, x) = {static_cast<float>(img->x() - 0.5), static_cast<float>(img->y() - 0.5)};
      const auto z = static_cast<float>(point.z());
      depths.at<float>(y, x) = z;
      float& there = nearest.at<float>(static_cast<int>(img->y()), static_cast<int>(img->x()));
      there = std::min(there, z);
    }
  AlignedExposure aligned{.light = {}, .seen = {}, .clipped = {}, .noise = exposure.noise, .ratio = ratio};
  cv::remap(exposure.light, aligned.light, where, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  // Clipping reaches as far as the interpolation does.
  cv::Mat around;
  cv::dilate(exposure.clipped, around, cv::Mat::ones(3, 3, CV_8UC1));
  cv::remap(around, aligned.clipped, where, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  aligned.clipped = aligned.clipped > cv::Scalar::all(0);
  aligned.seen = cv::Mat::zeros(depth.size(), CV_8UC1);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const float z = depths.at<float>(y, x);
      if (z == 0) continue;
      const cv::Vec2f at = where.at<cv::Vec2f>(y, x);
      const auto row = static_cast<int>(at[1] + 0.5f), column = static_cast<int>(at[0] + 0.5f);
      if (nearest.at<float>(row, column) > (1 - kHiddenBy) * z) aligned.seen.at<std::uint8_t>(y, x) = 255;
    }
  return aligned;
}

AlignedExposure WithoutAlignment(const ExposedLight& exposure, double ratio) {
  return {.light = exposure.light,
          .seen = cv::Mat(exposure.light.size(), CV_8UC1, cv::Scalar(255)),
          .clipped = exposure.clipped,
          .noise = exposure.noise,
          .ratio = ratio};
}

}  // namespace ulf
