// The renderer's shaders, built for the photographs and the proxy that there are.
#pragma once

#include <map>
#include <string>

#include "render/gl/gl_objects.h"
#include "render/scene/renderer.h"

namespace ulf::render {

class GlPrograms {
 public:
  // `has_triangles`: the proxy's depth is drawn first. What the scene does not need is left out.
  void Build(const RenderScene& scene, bool show_field, bool has_triangles);

  const GlProgram& cover() const { return cover_; }
  // For up to so many views of a triangle, `direct` where they are all that it has; built when it is first
  // needed.
  const GlProgram& FanBatch(int views, bool direct);
  int most_views_of_fan_batch() const { return most_views_of_fan_batch_; }
  // What the uniforms of a batch tell of all views at once, where they agree.
  bool one_camera() const { return one_camera_; }
  // Of a wide aperture's rings what FanBatch() multiplies light with; built when it is first needed.
  const GlProgram& RingWeight();
  const GlProgram& open() const { return open_; }
  const GlProgram& normalise() const { return normalise_; }
  const GlProgram& mark_lumigraph() const { return mark_lumigraph_; }
  const GlProgram& mark_fill() const { return mark_fill_; }
  // Those that read many photographs at a pixel, by how many texture arrays these lie in: built when they are
  // first needed.
  const GlProgram& Lumigraph(int arrays) { return Over(arrays).lumigraph; }
  const GlProgram& Fill(int arrays) { return Over(arrays).fill; }

  void Release();

 private:
  struct OverViews {
    GlProgram lumigraph, fill;
  };
  const OverViews& Over(int arrays);
  std::string Head(int arrays) const;
  std::string FanBatchVertices(int views) const;

  std::string defines_;
  bool one_camera_ = false;
  int most_views_of_fan_batch_ = 1;
  GlProgram cover_, open_, ring_weight_, normalise_, mark_lumigraph_, mark_fill_;
  bool has_ring_weight_ = false;
  std::map<int, OverViews> over_views_;
  std::map<std::pair<int, bool>, GlProgram> batches_;
};

}  // namespace ulf::render
