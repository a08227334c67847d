// Renders the subject of a turntable without the still background.
//
// The masks of the views are rendered as if they were photographs, with the same field over the same proxy:
// their blend tells the share of each pixel that shows the subject (Rendering::alpha). A photograph's masked
// pixels give no light, so that no colour of the background comes into the pictures.
#pragma once

#include <memory>

#include "render/fields/field_options.h"
#include "render/renderer/renderer.h"

namespace ulf::render {

// Up to the first of these blends of the masks alpha is 0, from the second on 1, linear between. Guessed:
// geometry that is off by a pixel at the rim makes views disagree there; the blend itself would leave a veil.
constexpr float kOutsideShare = 0.3f, kInsideShare = 0.7f;

class CutOutRenderer : public Renderer {
 public:
  // `of_masks` renders the same views from their masks (SceneOptions::of_masks).
  CutOutRenderer(std::unique_ptr<Renderer> of_light, std::unique_ptr<Renderer> of_masks)
      : light_(std::move(of_light)), masks_(std::move(of_masks)) {}

  Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) override;
  void SetField(const FieldOptions& field) override;
  void SetProxy(std::shared_ptr<const Proxy> proxy) override;
  void SetAperture(const std::optional<Aperture>& aperture) override;
  void Prefetch(const CameraModel& camera, const Rigid3& cam_from_world) override;
  bool loading() const override { return light_->loading() || masks_->loading(); }
  FieldOptions field() const override { return light_->field(); }
  std::string Name() const override { return light_->Name(); }
  const RenderScene& scene() const override { return light_->scene(); }

 private:
  std::unique_ptr<Renderer> light_, masks_;
};

}  // namespace ulf::render
