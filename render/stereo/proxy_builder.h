// Makes a triangle mesh of the scene from its photographs and their poses: depth maps by plane sweep for
// views that are spread over the light field, points where the maps of several views agree, and the surface
// between the space that views saw through and the points that they saw. The mesh covers what the views see
// well, the background included. Elsewhere there is no mesh, and a renderer uses the plane.
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

// What compares the photographs.
enum class SweepDevice { kProcessor, kGl };

struct ProxyOptions {
  int size_px =
      640;  // longer side of the photographs that are compared (docs/measured/speed_and_accuracy.md)
  int depth_maps = 60;  // at most. Guessed.
  int neighbours = 8;   // with which a view is compared. Guessed.
  MapsMeshOptions mesh = {};
  SweepDevice device = SweepDevice::kProcessor;
  bool keep_maps = false;  // make ProxyMesh::maps
};

// A mesh is rough where ProxySummary::pixel_depth_radii is larger: a warning is given. Guessed.
inline constexpr double kRoughPixelRadii = 0.5;

struct ProxySummary {
  int views = 0, depth_maps = 0;
  double agreeing_share = 0;  // of the maps' pixels
  std::size_t points = 0;
  std::string device;  // that compared the photographs
  // The change of depth at the subject that moves a point by one pixel in a neighbour, in the subject's
  // radii; the median of the views.
  double pixel_depth_radii = 0;
  double sweep_s = 0, fusion_s = 0, surface_s = 0;
};

struct ProxyMesh {
  TriangleMesh mesh;
  // By View::id: what the views' own maps say where others confirm it, and elsewhere the mesh.
  std::map<int, ViewDepthMap> maps;
  ProxySummary summary;
};

// Throws Error where the views give no geometry (fewer than two views, all in one place, no surface on which
// they agree), and for SweepDevice::kGl without OpenGL.
ProxyMesh BuildProxy(const RenderScene& scene, const ProxyOptions& options, Progress* progress = nullptr);

// The same in two steps, for several processes: the depth maps of a share of the views, and the mesh of the
// maps of all shares (FindSweptMaps()). What BuildProxy() gives does not depend on how it is shared out.
SweptMaps SweepShare(const RenderScene& scene, const ProxyOptions& options, const MapShare& share,
                     Progress* progress = nullptr);
// Throws Error where a map is missing, damaged or of another size than its view.
ProxyMesh BuildProxyOf(const SweptMapFiles& maps, const RenderScene& scene, const ProxyOptions& options,
                       Progress* progress = nullptr);
// Of the photographs, masks, cameras and poses, and of the options on which the maps depend. Reads the
// photographs' files.
std::uint64_t SweepDigest(const RenderScene& scene, const ProxyOptions& options);

// The views of which geometry is made, in the form that its stereo needs, `size_px` wide or high.
std::shared_ptr<const RenderScene> LoadForGeometry(const LightField& light_field, const SceneOptions& options,
                                                   int size_px);
// Throws Error that names the light field's folder where the views that are not left out are fewer than two.
void RequireViewsForMesh(const LightField& light_field, const std::filesystem::path& dir,
                         std::size_t left_out);

// The mesh and the depth maps of all views, with a progress line, into the light field's folder. A mesh that
// is there moves to kept/, with its depth maps. Throws as BuildProxy() does.
void WriteMeshProxy(const std::filesystem::path& dir);

}  // namespace ulf::render
