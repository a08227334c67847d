// The fast renderer: OpenGL 4.5 without a window, the same contract as the reference.
//
// Photographs lie in sRGB texture arrays with the reference's own pyramids as mip levels. Mesh fields draw
// each triangle of the field mesh that meets the frame once, all views that weigh in it read by one shader;
// nothing is blended, so no precision is lost between passes. The lumigraph field evaluates weights at the
// vertices of an image triangulation (about 2,000 triangles: a grid and the projected viewpoints) on the CPU
// and draws its triangles with the same shader, or evaluates them at every pixel over all views. A last pass
// fills what nothing covered.
#pragma once

#include "render/renderer.h"

namespace ulf {

class GlRenderer : public Renderer {
 public:
  // Throws Error without OpenGL 4.5, and when the photographs do not fit into its memory.
  GlRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options);
  ~GlRenderer() override;

  Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) override;
  void SetField(const FieldOptions& field) override;
  FieldOptions field() const override;
  std::string Name() const override;
  const RenderScene& scene() const override;

  // Draws and waits, without reading back: what an interactive viewer pays for a frame. Milliseconds.
  double Draw(const CameraModel& camera, const Rigid3& cam_from_world);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf
