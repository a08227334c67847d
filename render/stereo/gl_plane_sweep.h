// The sweep's matching costs by OpenGL: the same as those of MatchingCosts(), the reference, up to one unit
// of their eight bits. Meant for a GPU; a software rasteriser takes longer than the loops on the processor.
#pragma once

#include <string>

#include "render/gl/gl_context.h"
#include "render/gl/gl_objects.h"
#include "render/stereo/plane_sweep.h"

namespace ulf::render {

class GlPlaneSweep {
 public:
  GlPlaneSweep() = default;  // throws Error where there is no OpenGL
  ~GlPlaneSweep();

  // Only one thread at a time may call it.
  CostVolume MatchingCosts(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                           const InverseDepthRange& range, const SweepOptions& options = {});
  const std::string& device() const { return context_.device(); }
  bool IsSoftware() const;

 private:
  struct Shape {
    int radius = 0, neighbours = 0;
    bool operator==(const Shape&) const = default;
  };

  GlContext context_;
  Shape built_;
  GlProgram program_;
  GlEmptyVertexArray no_vertices_;
  GlTexelBuffer carriers_;
  GlTarget costs_{kCostsFormat};

  static const unsigned kCostsFormat;
};

}  // namespace ulf::render
