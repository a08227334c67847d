#include "render/scene/even_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/image/image.h"

namespace ulf::render {
namespace {

// Returns B G R and the share of the pixel that has light, CV_32FC4, linear, of the photograph's level.
cv::Mat EvenLightOf(const SceneView& view, int level) {
  const cv::Mat pixels = view.photograph->Level(level);
  cv::Mat light(pixels.size(), CV_32FC4);
  if (view.photograph->linear()) {
    pixels.convertTo(light, CV_32F);
  } else {
    const cv::Mat linear = LinearFloat({pixels, Transfer::kSrgb});
    cv::mixChannels(std::vector<cv::Mat>{linear, cv::Mat::ones(pixels.size(), CV_32F)}, {light},
                    {0, 0, 1, 1, 2, 2, 3, 3});
  }
  const double to_full = 1.0 * view.camera.width / pixels.cols;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      auto& at = light.at<cv::Vec4f>(y, x);
      if (!(at[3] > 0)) {
        at = {0, 0, 0, 0};
        continue;
      }
      const cv::Vec3f even = OnCommonScale(view, {at[0] / at[3], at[1] / at[3], at[2] / at[3]},
                                           {(x + 0.5) * to_full, (y + 0.5) * to_full});
      for (int c = 0; c < 3; ++c) at[c] = even[c];
    }
  return light;
}

}  // namespace

cv::Vec3f OnCommonScale(const SceneView& view, const cv::Vec3f& light, const Eigen::Vector2d& img) {
  return (light - cv::Vec3f::all(view.black)).mul(view.ScaleAt(img));
}

Undistortion UndistortionOf(const SceneView& view) {
  if (view.camera.distortion == Distortion::kNone)
    return {.from = view.camera, .to = view.camera, .is_identity = true};
  return ulf::UndistortionOf(view.camera, fmt::format("view {}", view.id));
}

cv::Mat EvenPicture(const SceneView& view, const Undistortion& full, const CameraModel& camera) {
  int level = 0;  // the smallest that is large enough
  while (level + 1 < view.photograph->LevelCount() &&
         view.photograph->LevelSize(level + 1).width * full.to.width >= camera.width * full.from.width)
    ++level;
  cv::Mat light = EvenLightOf(view, level);
  if (!full.is_identity) {
    Undistortion here = full;
    here.from = full.from.ScaledTo(light.cols, light.rows);
    const double share = 1.0 * light.cols / full.from.width;
    here.to = full.to.ScaledTo(std::max(1, static_cast<int>(std::lround(share * full.to.width))),
                               std::max(1, static_cast<int>(std::lround(share * full.to.height))));
    light = Undistorted(MapOf(here), light);
  }
  if (light.cols != camera.width || light.rows != camera.height)
    cv::resize(light, light, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  cv::Mat bgr, share, picture;
  cv::cvtColor(light, bgr, cv::COLOR_BGRA2BGR);
  cv::extractChannel(light, share, 3);
  picture = Srgb8FromLinear(bgr);
  double least = 1;
  cv::minMaxLoc(share, &least);
  if (least > 0.5) return picture;
  cv::Mat alpha, with_alpha;
  share.convertTo(alpha, CV_8U, 255);
  cv::merge(std::vector<cv::Mat>{picture, alpha}, with_alpha);
  return with_alpha;
}

}  // namespace ulf::render
