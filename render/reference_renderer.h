// The plain renderer that every fast path is compared with: one thread, one pixel after the other, double
// precision up to the photograph's pixels and float light.
#pragma once

#include "render/renderer.h"

namespace ulf {

class ReferenceRenderer : public Renderer {
 public:
  ReferenceRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options);
  Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) override;
  void SetField(const FieldOptions& field) override;
  void SetProxy(std::shared_ptr<const Proxy> proxy) override;
  FieldOptions field() const override { return options_.field; }
  std::string Name() const override { return "reference"; }
  const RenderScene& scene() const override { return *scene_; }

 private:
  std::shared_ptr<const RenderScene> scene_;
  RenderOptions options_;
  std::unique_ptr<BlendingField> field_;
};

// What Rendering::weights asks for, of the field at every pixel; `depth` as from Proxy::Depth().
std::vector<ViewWeights> WeightsOfViews(const RenderScene& scene, const BlendingField& field,
                                        const CameraModel& camera, const Rigid3& cam_from_world,
                                        const cv::Mat& depth, bool fill);

// Bilinear between pixel centres, edges continued, in linear light: B G R and how much of the four pixels has
// light at all. `img` in pixels of the view's camera, whatever the level.
cv::Vec4f SampleLevel(const cv::Mat& level, const CameraModel& camera, const Eigen::Vector2d& img);

}  // namespace ulf
