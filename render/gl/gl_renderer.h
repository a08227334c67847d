// The fast renderer: OpenGL 4.5 without a window, with the same contract as the reference renderer.
//
// If the proxy has triangles, their depth is drawn first, and every later pass reads it.
//
// For each photograph that a picture needs, the level that it reads lies in a texture array
// (render/gl/gl_photographs). Triangles that meet the image are drawn in batches. A fan (the thesis's word)
// is a triangle with one of the views that have weight in it; a batch is up to nine fans of a triangle whose
// photographs lie in one array. The data of the views are constant over a triangle and passed with its
// vertices, so that fragments read no buffers; on a software rasteriser this is many times faster. Usually
// every triangle has one batch: with one camera, one level of subdivision and no viewpoint with more than
// eight neighbours. Then the pixels are finished at once, in the order of the triangles (of overlapping
// triangles the last one counts). Otherwise a first pass draws the triangles' order and confidence, a second
// adds up their batches in 32-bit float, and a third divides by the sum of weights.
//
// The lumigraph field computes weights on the processor at the vertices of an image triangulation (about
// 2,000 triangles: a grid and the projected viewpoints) and draws its triangles in the same way, or computes
// them at every pixel over all views. The rings of a wide aperture are added to the field. The last pass
// fills pixels that nothing covered: in each tile of the picture it goes through the views that have the tile
// in their images (render/scene/view_tiles).
//
// A picture whose photographs do not fit into memory at the same time is drawn in several passes; it differs
// only by the rounding of sums. Before passes over all views, a marking pass finds the needed views.
#pragma once

#include <memory>

#include "render/fields/field_options.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_photographs.h"
#include "render/renderer/renderer.h"

namespace ulf::render {

// Options for showing a picture on a screen.
struct DisplayTransform {
  double exposure_stops = 0;
  bool hatches_doubt = false;  // stripes pixels of low confidence, the lower the stronger
  // A renderer of the views' masks (SceneOptions::of_masks) in the same context, with the same camera drawn:
  // what the masks exclude is covered by a plain grey (CutOutRenderer). Null: nothing is excluded.
  const class GlRenderer* of_masks = nullptr;
};

class GlRenderer : public Renderer {
 public:
  // Throws Error without OpenGL 4.5. With kCurrent it draws in the caller's context, which must be current at
  // every call and in the destructor.
  GlRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options,
             GlContextKind kind = GlContextKind::kOwn);
  ~GlRenderer() override;

  Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) override;
  void SetField(const FieldOptions& field) override;
  void SetProxy(std::shared_ptr<const Proxy> proxy) override;
  void SetAperture(const std::optional<Aperture>& aperture) override;
  void Prefetch(const CameraModel& camera, const Rigid3& cam_from_world) override;
  bool loading() const override;
  GlPhotographs::Counts photograph_counts() const;
  // Returns whether the triangles of the last picture were finished at once, not added up.
  bool drew_at_once() const;
  FieldOptions field() const override;
  std::string Name() const override;
  const RenderScene& scene() const override;

  // Draws and waits without reading the picture back, as an interactive viewer does. Returns milliseconds.
  double Draw(const CameraModel& camera, const Rigid3& cam_from_world);
  // Shows the picture of the last Draw(), in sRGB, stretched over the viewport of the framebuffer that is
  // bound in the caller's context (kCurrent).
  void Show(const DisplayTransform& transform) const;
  // Sets RenderOptions::show_field.
  void ShowField(bool show);

 private:
  std::unique_ptr<struct GlRendererState> state_;
};

// Makes the renderer of options.renderer. Throws Error without views, or for kGl without OpenGL 4.5.
std::unique_ptr<Renderer> MakeRenderer(std::shared_ptr<const RenderScene> scene,
                                       const RenderOptions& options);

}  // namespace ulf::render
