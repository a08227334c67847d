// The reference renderer, against which the OpenGL renderer is tested. It draws in one thread, pixel by
// pixel, in double precision up to the place in a photograph, with light as float.
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

// Interpolates a photograph's level bilinearly between pixel centres, edges repeated: linear B G R, not
// premultiplied, and the share of the four pixels that has light (0: none). `img` is in `camera`'s pixels.
cv::Vec4f SampleLevel(const cv::Mat& level, const CameraModel& camera, const Eigen::Vector2d& img);

// Does the same for a view, on the scene's common scale of light. `level` is one of its photograph.
cv::Vec4f LightOfView(const SceneView& view, const cv::Mat& level, const Eigen::Vector2d& img);

}  // namespace ulf::render
