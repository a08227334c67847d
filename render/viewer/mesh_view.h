// The mesh of the viewpoints drawn over a picture (thesis, figure 5-3), where the camera's rays cross it: at
// a corner the piecewise-linear field is that view alone. Triangles behind the camera are drawn where the
// lines through it meet them (mesh_field.h).
#pragma once

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/display/shapes.h"
#include "render/fields/mesh_field.h"

namespace ulf::render {

// `coarse` is the mesh as triangulated; the edges of `fine`, where there is one, are thin. The strips past
// the hull are faint; viewpoints have the colours of the blending field's picture.
Overlay MeshView(const MeshField& coarse, const MeshField* fine, const RenderScene& scene,
                 const CameraModel& camera, const Rigid3& cam_from_world);

}  // namespace ulf::render
