// Computes the light that depends on the viewpoint: what glazed, polished and glass surfaces send to the eye
// besides their baked light. World frame, metres; radiance linear B, G, R.
//
// Fresnel reflection follows Schlick 1994; glass refracts by Snell's law, index 1.5, at each surface of its
// solid. What is seen in a mirror or through glass is the baked light of the first opaque surface there.
#pragma once

#include "acquisition/simulator/scene/scene.h"

namespace ulf::acquisition {

// A ray from the eye that has met a surface.
struct SurfaceView {
  Eigen::Vector3f point, normal, direction;  // the direction is the ray's, towards the surface
  float distance = 0;                        // from the eye
  float pixel_angle = 0;                     // radians
  double sway_angle = 0;                     // of the scene's moving parts
};

// Returns the radiance of a surface towards the eye; `matte`: its baked radiance, `part`: index of its solid
// in Scene::primitives().
F4 SurfaceLight(const Scene& scene, int part, F4 matte, const SurfaceView& view);

}  // namespace ulf::acquisition
