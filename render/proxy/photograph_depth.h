// Tells the depth of each pixel of a light field's photographs, for programs that train with depths: along
// the optical axis, from the view's own depth map, or from the mesh where the view has none. It is unknown
// where the photograph shows nothing of the mesh, and beyond 71 degrees from the axis.
//
// Depth maps of other views judge a depth: each in whose picture the point lies either agrees, sees through
// it, or sees something nearer and cannot tell. The confidence is the share of those that agree among those
// that can tell: 0 where none agrees or none can tell, and unknown in a light field without maps.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/light_field/exchange/export_options.h"
#include "core/light_field/light_field.h"
#include "render/proxy/soft_proxy.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

class PhotographDepths {
 public:
  // Reads the light field's mesh and depth maps (depth_map_files.h); maps that cannot be used are a warning.
  // Throws Error if there is no mesh. `light_field` must outlive it.
  explicit PhotographDepths(const LightField& light_field);
  PhotographDepths(const LightField& light_field, std::shared_ptr<const TriangleMesh> mesh,
                   SoftProxy::Maps maps);

  // Returns the depths of the pixels of `camera`, which stands where the view does and looks the same way.
  // A view of another pose than the light field's gets those of the mesh.
  // Several threads may call it.
  PhotographDepth Of(const View& view, const CameraModel& camera) const;

  bool HasConfidence() const { return !maps_.empty(); }

 private:
  const LightField& light_field_;
  std::shared_ptr<const TriangleMesh> mesh_;
  SoftProxy::Maps maps_;
};

// Returns the number of world units that 1 stands for in 16-bit pictures of these depths: a thousandth
// (millimetres, where the unit is the metre) if it shows the farthest depths, and the nearest to a fifth of a
// per cent; else the smallest power of ten that shows the farthest.
double UnitForSixteenBits(const PhotographDepths& depths, const LightField& light_field);

}  // namespace ulf::render
