// The fast renderer: OpenGL 4.5 without a window, the same contract as the reference.
//
// Where the proxy has triangles their depth is drawn first, and every later pass reads it.
//
// Of each photograph that a picture needs the one level that it reads lies in a texture array
// (render/gl/gl_photographs). Triangles that meet the frame are drawn as batches: the fans of the thesis, a
// triangle and a view that weighs in it, of up to nine views together whose photographs lie in one array.
// What fragments need of the views is constant over a triangle and travels with it, so they read no buffers;
// on a software rasteriser this is many times faster. Where every triangle is one batch, which is the rule
// with one camera, one level of subdivision and no viewpoint of more than eight neighbours, their pixels are
// finished at once, in the triangles' order (of overlapping ones the last counts). Else triangles are drawn
// for their order and confidence first, then their batches are added up in 32-bit float, and a pass divides
// by the sum of weights.
//
// The lumigraph field evaluates weights at the vertices of an image triangulation (about 2,000 triangles: a
// grid and the projected viewpoints) on the CPU and draws its triangles the same way, or evaluates them at
// every pixel over all views. Rings of a wide aperture are added to the field. A last pass fills what nothing
// covered, looking in each tile of the picture through the views that have it in their images
// (render/scene/view_tiles).
//
// A picture whose photographs are not there all at once is drawn in several passes, and is the same but for
// the rounding of sums. Passes over all views first let the graphics side mark those that pixels are going to
// need.
#pragma once

#include "render/gl/gl_context.h"
#include "render/gl/gl_photographs.h"
#include "render/scene/renderer.h"

namespace ulf::render {

// How what was drawn is shown on a screen.
struct DisplayTransform {
  double exposure_stops = 0;
  bool hatches_doubt = false;  // stripes, the stronger the less the confidence
};

class GlRenderer : public Renderer {
 public:
  // Throws Error without OpenGL 4.5. With kCurrent it draws in its caller's context, which is current
  // whenever it is called and when it goes.
  GlRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options,
             GlContextKind door = GlContextKind::kOwn);
  ~GlRenderer() override;

  Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) override;
  void SetField(const FieldOptions& field) override;
  void SetProxy(std::shared_ptr<const Proxy> proxy) override;
  void SetAperture(const std::optional<Aperture>& aperture) override;
  void Prefetch(const CameraModel& camera, const Rigid3& cam_from_world) override;
  bool loading() const override;
  GlPhotographs::Counts photograph_counts() const;
  // Of the last picture: triangles were finished as they were drawn, not added up.
  bool drew_at_once() const;
  FieldOptions field() const override;
  std::string Name() const override;
  const RenderScene& scene() const override;

  // Draws and waits, without reading back: what an interactive viewer pays for a frame. Milliseconds.
  double Draw(const CameraModel& camera, const Rigid3& cam_from_world);
  // What Draw() drew, in sRGB, onto the framebuffer that is bound in the caller's context, filling its
  // viewport. Every pixel is written.
  void Show(const DisplayTransform& transform) const;
  // A colour for each view in place of its photograph, or not.
  void ShowField(bool show);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::render
