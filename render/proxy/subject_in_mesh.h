// What stands in the subject's sphere, by a mesh of the scene: how large the subject really is, as far as it was
// seen. The plane that it stands on, and what lies behind that plane, is left out; of the rest, the connected
// surfaces in the sphere count whole.
#pragma once

#include <optional>

#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// Lengths are shares of the sphere's radius. Guessed; tried on simulated scenes (tests/render/proxy/).
struct SubjectInMeshOptions {
  double reach = 3;               // from the sphere's centre: farther surfaces are not looked at
  double plane_thickness = 0.05;  // to either side of the plane
  double least_plane = 0.15;      // share of the area within reach that lies in the plane; less is no support
  int planes_tried = 300;
  double inside = 1.0;          // surfaces with their middle nearer than this belong to the subject
  double least_surface = 0.03;  // share of the largest one's area; smaller surfaces are noise
  double left_out = 0.02;       // share of the area that may stick out of the sphere that is found
  double most_radius = 2;       // more is the scene, not the subject
};
// None where nothing stands apart in the sphere: no surface, or one that goes on into the scene (a picture on its
// wall, an object whose gaps are bridged).
std::optional<Subject> SubjectInMesh(const TriangleMesh& mesh, const Subject& sphere,
                                     const SubjectInMeshOptions& options = {});

}  // namespace ulf::render
