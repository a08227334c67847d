// The fast renderer: OpenGL 4.5 without a window, the same contract as the reference.
//
// Where the proxy has triangles their depth is drawn first, and every later pass reads it.
//
// Photographs lie in sRGB texture arrays with the reference's own pyramids as mip levels. Triangles that meet
// the frame are drawn twice: once each for their order (of overlapping ones the last counts) and confidence,
// then once for each view that weighs in them, added up in 32-bit float (the thesis's fans, all in one draw).
// What fragments need of a view is constant over a triangle, so they read no buffers: on a software
// rasteriser this is many times faster than one pass per triangle whose shader reads all its views. The
// lumigraph field evaluates weights at the vertices of an image triangulation (about 2,000 triangles: a grid
// and the projected viewpoints) on the CPU and draws its triangles the same way, or evaluates them at every
// pixel over all views. A last pass divides by the sum of weights and fills what nothing covered.
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
  void SetProxy(std::shared_ptr<const Proxy> proxy) override;
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
