#include "render/stereo/stereo_view.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/geometry/pinhole.h"

namespace ulf::render {

namespace {

// Returns 255 where the whole pixel has light; empty if all pixels have.
cv::Mat ValidPart(const Photograph& photograph) {
  if (!photograph.linear()) return {};
  cv::Mat light, share;
  photograph.Level(0).convertTo(light, CV_32F);  // OpenCV cannot extract a channel of half floats
  cv::extractChannel(light, share, 3);
  constexpr float kWhole = 0.99f;  // rounding of half floats
  const cv::Mat valid = share > kWhole;
  return cv::countNonZero(valid) == static_cast<int>(valid.total()) ? cv::Mat() : valid;
}

// Returns for cv::remap the place in the photograph of each pixel of its undistorted image.
cv::Mat UndistortionPlaces(const CameraModel& camera, const cv::Size& size) {
  const CameraModel pinhole = camera.WithoutDistortion();
  cv::Mat from(size, CV_32FC2);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto img = camera.ImgFromCam(PinholeRay(pinhole, x, y));
      from.at<cv::Vec2f>(y, x) =
          img ? cv::Vec2f(static_cast<float>(img->x() - 0.5),  // OpenCV's origin is the first pixel's centre
                          static_cast<float>(img->y() - 0.5))
              : cv::Vec2f(-10, -10);
    }
  return from;
}

cv::Mat Reduced(const cv::Mat& picture, const cv::Size& size) {
  if (picture.size() == size) return picture;
  cv::Mat reduced;
  cv::resize(picture, reduced, size, 0, 0, cv::INTER_AREA);
  return reduced;
}

}  // namespace

std::optional<Eigen::Vector2d> StereoView::Project(const Eigen::Vector3d& point_in_world) const {
  const auto img = camera.ImgFromCam(cam_from_world * point_in_world);
  if (!img || !camera.Contains(*img)) return std::nullopt;
  return img;
}

Eigen::Vector3d StereoView::RayInWorld(int x, int y) const {
  return cam_from_world.DirectionInSource(PinholeRay(camera, x, y));
}

StereoView HalfSize(const StereoView& view) {
  StereoView half = view;
  half.camera = view.camera.ScaledTo(std::max(1, view.camera.width / 2), std::max(1, view.camera.height / 2));
  const cv::Size size(half.camera.width, half.camera.height);
  half.grey = Reduced(view.grey, size);
  if (!view.valid.empty()) half.valid = Reduced(view.valid, size) == 255;
  return half;
}

StereoView MakeStereoView(const SceneView& view, int size_px) {
  StereoView result;
  result.camera = Within(view.camera, size_px).WithoutDistortion();
  result.cam_from_world = view.cam_from_world;
  result.center_in_world = view.center_in_world;

  cv::Mat grey;
  cv::cvtColor(view.Srgb8(), grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_32F);
  cv::Mat valid = ValidPart(*view.photograph);
  if (view.camera.distortion != Distortion::kNone) {
    const cv::Mat from = UndistortionPlaces(view.camera, grey.size());
    cv::remap(grey.clone(), grey, from, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    if (!valid.empty())
      cv::remap(valid.clone(), valid, from, cv::noArray(), cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  }
  const cv::Size size(result.camera.width, result.camera.height);
  result.grey = Reduced(grey, size);
  if (!valid.empty()) result.valid = Reduced(valid, size) == 255;
  return result;
}

StereoView StereoViewMaker::Make(const cv::Mat& srgb8, const CameraModel& camera,
                                 const Rigid3& cam_from_world) {
  StereoView result;
  const CameraModel reduced = Within(camera, size_px_);
  result.camera = reduced.WithoutDistortion();
  result.cam_from_world = cam_from_world;
  result.center_in_world = cam_from_world.OriginInSource();
  const cv::Size size(reduced.width, reduced.height);
  cv::Mat grey;
  cv::cvtColor(Reduced(srgb8, size), grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(result.grey, CV_32F);
  if (camera.distortion == Distortion::kNone) return result;
  if (camera_ != camera) {
    undistortion_ = UndistortionPlaces(reduced, size);
    camera_ = camera;
  }
  cv::remap(result.grey.clone(), result.grey, undistortion_, cv::noArray(), cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  return result;
}

}  // namespace ulf::render
