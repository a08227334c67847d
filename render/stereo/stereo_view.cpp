#include "render/stereo/stereo_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf {

std::optional<Eigen::Vector2d> StereoView::See(const Eigen::Vector3d& point_in_world) const {
  const auto img = camera.ImgFromCam(cam_from_world * point_in_world);
  if (!img || !camera.Contains(*img)) return std::nullopt;
  return img;
}

Eigen::Vector3d StereoView::RayInWorld(int x, int y) const {
  return cam_from_world.DirectionInSource(
      {(x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1.0});
}

StereoView MakeStereoView(const SceneView& view, int size_px) {
  StereoView result;
  const int longer = std::max(view.camera.width, view.camera.height);
  const double scale = std::min(1.0, static_cast<double>(size_px) / longer);
  const CameraModel pinhole = view.camera.WithoutDistortion();
  result.camera = pinhole.ScaledTo(std::max(1, static_cast<int>(std::lround(pinhole.width * scale))),
                                   std::max(1, static_cast<int>(std::lround(pinhole.height * scale))));
  result.cam_from_world = view.cam_from_world;
  result.center_in_world = view.center_in_world;

  cv::Mat grey;
  cv::cvtColor(view.Srgb8(), grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_32F);
  if (view.camera.distortion != Distortion::kNone) {
    cv::Mat from(grey.size(), CV_32FC2);
    for (int y = 0; y < grey.rows; ++y)
      for (int x = 0; x < grey.cols; ++x) {
        const auto img = view.camera.ImgFromCam(
            {(x + 0.5 - pinhole.cx) / pinhole.fx, (y + 0.5 - pinhole.cy) / pinhole.fy, 1.0});
        from.at<cv::Vec2f>(y, x) = img ? cv::Vec2f(static_cast<float>(img->x() - 0.5),  // OpenCV's pixels
                                                   static_cast<float>(img->y() - 0.5))
                                       : cv::Vec2f(-10, -10);
      }
    cv::Mat straight;
    cv::remap(grey, straight, from, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    grey = straight;
  }
  if (grey.cols != result.camera.width || grey.rows != result.camera.height)
    cv::resize(grey, result.grey, {result.camera.width, result.camera.height}, 0, 0, cv::INTER_AREA);
  else
    result.grey = grey;
  return result;
}

}  // namespace ulf
