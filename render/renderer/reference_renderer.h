// The reference renderer, against which the OpenGL renderer is tested: one thread, one pixel after the other,
// double precision up to the photograph's pixels, float light.
#pragma once

#include "render/fields/aperture_field.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/renderer/renderer.h"

namespace ulf::render {

class ReferenceRenderer : public Renderer {
 public:
  ReferenceRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options);
  Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) override;
  void SetField(const FieldOptions& field) override;
  void SetProxy(std::shared_ptr<const Proxy> proxy) override;
  void SetAperture(const std::optional<Aperture>& aperture) override;
  FieldOptions field() const override { return options_.field; }
  std::string Name() const override { return "reference"; }
  const RenderScene& scene() const override { return *scene_; }

 private:
  // Returns null for the soft field.
  std::unique_ptr<PlacedField> FieldFrom(const CameraModel& camera, const Rigid3& cam_from_world,
                                         const cv::Mat& depth) const;

  std::shared_ptr<const RenderScene> scene_;    // with its own proxy
  std::shared_ptr<const RenderScene> focused_;  // with the focal plane; null without an aperture
  RenderOptions options_;
  std::unique_ptr<BlendingField> field_;           // null: the soft field
  std::unique_ptr<ApertureField> aperture_field_;  // null without an aperture or a mesh
};

// Returns Rendering::weights of a field (null: the soft field); `depth` comes from Proxy::Depth().
std::vector<ViewWeights> WeightsOfViews(const RenderScene& scene, const PlacedField* field,
                                        const CameraModel& camera, const Rigid3& cam_from_world,
                                        const cv::Mat& depth, const RenderOptions& options);

// Interpolates bilinearly between pixel centres, edges repeated, in linear light: B G R and the share of the
// four pixels that has light. `img` is in pixels of the view's camera, for every level.
cv::Vec4f SampleLevel(const cv::Mat& level, const CameraModel& camera, const Eigen::Vector2d& img);

// Returns light of a view at a point, linear B G R on the scene's common scale, and the share of it that the
// photograph has there (0: none). `level` is one of the pyramid.
cv::Vec4f LightOfView(const SceneView& view, const cv::Mat& level, const Eigen::Vector2d& img);

}  // namespace ulf::render
