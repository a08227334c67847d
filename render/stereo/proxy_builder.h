// A triangle mesh of the scene from its photographs and their poses: depth maps by plane sweep for views that
// are spread over the light field, points where the maps of several views agree, and the surface between what
// views saw through and what they saw. Covers whatever views see well, the background included; where nothing
// is known there is no mesh, and a renderer falls back to the plane.
//
// Assumes that poses are right to about a pixel of the working size and that nothing moved. The same input
// gives the same mesh, whatever the number of threads.
#pragma once

#include <cstddef>
#include <string>

#include "core/base/progress.h"
#include "render/proxy/triangle_mesh.h"
#include "render/scene/scene.h"

namespace ulf::render {

// Where pictures are compared.
enum class SweepDevice { kAuto, kGl, kProcessor };  // auto: OpenGL where a GPU draws, not software

struct ProxyOptions {
  int size_px = 480;    // longer side of the pictures that are compared
  int depth_maps = 60;  // at most
  int neighbours = 8;   // that a picture is compared with
  int most_triangles = 400000;
  SweepDevice device = SweepDevice::kAuto;
};

// A mesh is rough where a pixel is worth more than this.
inline constexpr double kRoughPixelRadii = 0.5;

struct ProxySummary {
  int views = 0, depth_maps = 0;
  double agreeing_share = 0;  // of the maps' pixels
  std::size_t points = 0;
  std::string device;  // that compared pictures
  // What a pixel between neighbours is worth in depth at the subject, in its radii: the views' median.
  double pixel_depth_radii = 0;
  double sweep_s = 0, fusion_s = 0, surface_s = 0;
};

struct ProxyMesh {
  TriangleMesh mesh;
  ProxySummary summary;
};

// Throws Error where the views give no geometry: fewer than two, all in one place, nothing on which they
// agree; SweepDevice::kGl without any OpenGL.
ProxyMesh BuildProxy(const RenderScene& scene, const ProxyOptions& options, Progress* progress = nullptr);

}  // namespace ulf::render
