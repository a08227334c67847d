// Draws the viewpoint mesh over a picture (thesis, figure 5-3), where the camera's rays cross it: at a corner
// the piecewise linear field shows the view of that corner alone. Triangles behind the camera are drawn where
// the lines through the camera's centre meet them (mesh_field.h).
#pragma once

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/display/shapes.h"
#include "render/fields/mesh_field.h"

namespace ulf::render {

// Returns the edges and viewpoints as shapes. `coarse` is the mesh without subdivision; `fine` the subdivided
// mesh, whose edges are thin, or null. The strips that extend the mesh past the hull are faint. Viewpoints
// have the colours of ViewColor().
Overlay MeshView(const MeshField& coarse, const MeshField* fine, const RenderScene& scene,
                 const CameraModel& camera, const Rigid3& cam_from_world);

}  // namespace ulf::render
