// Makes a triangle mesh of the scene from its photographs and their poses: depth maps by plane sweep for
// views that are spread over the light field, points where the maps of several views agree, and the surface
// between free space and these points. The mesh covers what the views see well, the background included.
// Elsewhere there is no mesh, and a renderer uses the plane.
//
// Poses must be right to about a pixel of the working size, and nothing may have moved. The same input gives
// the same mesh, whatever the number of threads.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "core/base/progress.h"
#include "render/proxy/triangle_mesh.h"
#include "render/proxy/view_depth_map.h"
#include "render/scene/scene.h"
#include "render/stereo/mesh_of_maps.h"
#include "render/stereo/swept_maps.h"

namespace ulf::render {

// The processor or the graphics card compares the photographs.
enum class SweepDevice { kProcessor, kGl };

struct ProxyOptions {
  int size_px = 640;    // px, longer side of compared photographs (docs/measured/speed_and_accuracy.md)
  int depth_maps = 60;  // largest number. Guessed.
  int neighbours = 8;   // number of views that a view is compared with. Guessed.
  MapsMeshOptions mesh = {};
  SweepDevice device = SweepDevice::kProcessor;
  bool keep_maps = false;  // fill ProxyMesh::maps
};

// Commands warn of a rough mesh if ProxySummary::pixel_depth_radii is larger. Guessed.
inline constexpr double kRoughPixelRadii = 0.5;

struct ProxySummary {
  int views = 0, depth_maps = 0;
  double agreeing_share = 0;  // of the maps' pixels
  std::size_t points = 0;
  std::string device;  // what compared the photographs: "processor", OpenGL's device, or "earlier"
  // The change of depth at the subject that moves a point by one pixel in a neighbour, in the subject's
  // radii; the median of the views.
  double pixel_depth_radii = 0;
  double sweep_s = 0, fusion_s = 0, surface_s = 0;
};

struct ProxyMesh {
  TriangleMesh mesh;
  // By View::id: the views' own maps where others confirm them, and elsewhere the mesh.
  std::map<int, ViewDepthMap> maps;
  ProxySummary summary;
};

// `scene` is LoadForGeometry(). Throws Error if the views give no geometry (fewer than two views, all in one
// place, no surface on which they agree), and for SweepDevice::kGl without OpenGL.
ProxyMesh BuildProxy(const RenderScene& scene, const ProxyOptions& options, Progress* progress = nullptr);

// SweepShare() and BuildProxyOf() do the same in two steps, for several processes: they make the depth maps
// of a share of the views, and the mesh of the maps of all shares (FindSweptMaps()). The result does not
// depend on the shares.
SweptMaps SweepShare(const RenderScene& scene, const ProxyOptions& options, const MapShare& share,
                     Progress* progress = nullptr);
// Throws Error if a map is missing, damaged or of another size than its view.
ProxyMesh BuildProxyOf(const SweptMapFiles& maps, const RenderScene& scene, const ProxyOptions& options,
                       Progress* progress = nullptr);
// Reads the photographs. Returns a digest of all on which maps depend: these, masks, cameras, poses, options.
std::uint64_t SweepDigest(const RenderScene& scene, const ProxyOptions& options);

// Loads the views from which geometry is made: 8 bits, or linear if there are masks, of at most `size_px`.
std::shared_ptr<const RenderScene> LoadForGeometry(const LightField& light_field, const SceneOptions& options,
                                                   int size_px);
// Throws Error that names the folder `dir` if fewer than two views remain without `left_out` of them.
void RequireViewsForMesh(const LightField& light_field, const std::filesystem::path& dir,
                         std::size_t left_out);

// Writes the mesh and the depth maps of all views, with a progress line, into the light field's folder. An
// existing mesh moves to kept/, with its depth maps. Throws as BuildProxy() does.
void WriteMeshProxy(const std::filesystem::path& dir);

}  // namespace ulf::render
