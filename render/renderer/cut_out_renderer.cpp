#include "render/renderer/cut_out_renderer.h"

#include <algorithm>

namespace ulf::render {

Rendering CutOutRenderer::Render(const CameraModel& camera, const Rigid3& cam_from_world) {
  Rendering picture = light_->Render(camera, cam_from_world);
  const Rendering mask = masks_->Render(camera, cam_from_world);
  picture.alpha.create(picture.linear.size(), CV_32F);
  for (int y = 0; y < picture.alpha.rows; ++y)
    for (int x = 0; x < picture.alpha.cols; ++x) {
      const bool drawn = picture.drawn.at<std::uint8_t>(y, x) != 0 && mask.drawn.at<std::uint8_t>(y, x) != 0;
      const float share = drawn ? mask.linear.at<cv::Vec3f>(y, x)[1] : 0;
      picture.alpha.at<float>(y, x) =
          std::clamp((share - kOutsideShare) / (kInsideShare - kOutsideShare), 0.0f, 1.0f);
    }
  picture.ms += mask.ms;
  return picture;
}

void CutOutRenderer::SetField(const FieldOptions& field) {
  light_->SetField(field);
  masks_->SetField(field);
}

void CutOutRenderer::SetProxy(std::shared_ptr<const Proxy> proxy) {
  light_->SetProxy(proxy);
  masks_->SetProxy(std::move(proxy));
}

void CutOutRenderer::SetAperture(const std::optional<Aperture>& aperture) {
  light_->SetAperture(aperture);
  masks_->SetAperture(aperture);
}

void CutOutRenderer::Prefetch(const CameraModel& camera, const Rigid3& cam_from_world) {
  light_->Prefetch(camera, cam_from_world);
  masks_->Prefetch(camera, cam_from_world);
}

}  // namespace ulf::render
