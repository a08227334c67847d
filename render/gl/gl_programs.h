// The renderer's shaders, built for the scene's photographs and proxy. The context must be current.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "render/gl/gl_objects.h"
#include "render/renderer/renderer.h"

namespace ulf::render {

class GlPrograms {
 public:
  // `has_triangles`: the proxy has triangles, whose depth is drawn first. Leaves out code of no use.
  void Build(const RenderScene& scene, bool show_field, bool has_triangles);

  const GlProgram& cover() const { return cover_; }  // draws the triangles' order and confidence
  // Returns the program that adds the light of up to `views` views of a triangle; `direct`: these are all its
  // views, and it finishes the pixels. It is built at the first call.
  const GlProgram& FanBatch(int views, bool direct);
  int most_views_of_fan_batch() const { return most_views_of_fan_batch_; }
  // Returns whether all views have the same camera, which then is a uniform.
  bool one_camera() const { return one_camera_; }
  // Returns the program that adds up the weights of a wide aperture's rings; built at the first call.
  const GlProgram& RingWeight();
  const GlProgram& open() const { return open_; }            // draws every pixel, to count the uncovered ones
  const GlProgram& normalise() const { return normalise_; }  // divides by the sum of weights
  // Both mark the views whose photographs the pixels of Lumigraph() and Fill() need.
  const GlProgram& mark_lumigraph() const { return mark_lumigraph_; }
  const GlProgram& mark_fill() const { return mark_fill_; }
  // These read many photographs at a pixel, from `arrays` texture arrays, and are built at the first call.
  const GlProgram& Lumigraph(int arrays) { return Over(arrays).lumigraph; }
  const GlProgram& Fill(int arrays) { return Over(arrays).fill; }
  const GlProgram& Soft(int arrays);

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
  std::map<int, GlProgram> soft_;
  std::map<std::pair<int, bool>, GlProgram> batches_;
};

}  // namespace ulf::render
