// Computes the matching costs of the plane sweep by OpenGL: they equal those of MatchingCosts() of
// plane_sweep.h, the reference, up to one unit of their eight bits. This is meant for a GPU; a software
// rasteriser takes longer than the loops on the processor.
#pragma once

#include <string>

#include "render/gl/gl_context.h"
#include "render/gl/gl_objects.h"
#include "render/stereo/plane_sweep.h"

namespace ulf::render {

class GlPlaneSweep {
 public:
  // Throws Error if there is no OpenGL. `band_bytes` is the memory of costs that are computed at a time.
  explicit GlPlaneSweep(std::size_t band_bytes = kBandBytes) : band_bytes_(band_bytes) {}
  ~GlPlaneSweep();

  // Call it only in the thread that made the object. Throws Error if the pictures are too large for the GPU.
  CostVolume MatchingCosts(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                           const InverseDepthRange& range, const SweepOptions& options = {});
  const std::string& device() const { return context_.device(); }

 private:
  static constexpr std::size_t kBandBytes = 64 << 20;  // a driver kills passes that take too long. Guessed.
  struct Shape {
    int radius = 0, neighbours = 0;
    bool operator==(const Shape&) const = default;
  };

  std::size_t band_bytes_;
  GlContext context_;
  Shape built_;
  GlProgram program_;
  GlTexelBuffer carriers_;
  GlBuffer inverse_depths_, costs_;
};

}  // namespace ulf::render
