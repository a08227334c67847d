// The data of a GlRenderer and its passes. It is private to gl_renderer.cpp (the order of passes),
// gl_over_triangles.cpp (passes over triangles) and gl_over_views.cpp (passes whose pixels go through all
// views), where comments explain the functions.
#pragma once

#include <epoxy/gl.h>

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/fields/aperture_field.h"
#include "render/fields/blending_field.h"
#include "render/fields/image_triangulation.h"
#include "render/fields/mesh_field.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_depth_maps.h"
#include "render/gl/gl_objects.h"
#include "render/gl/gl_photographs.h"
#include "render/gl/gl_programs.h"
#include "render/gl/gl_proxy.h"
#include "render/gl/gl_shadow_maps.h"
#include "render/gl/gl_triangles.h"
#include "render/gl/gl_views.h"
#include "render/renderer/renderer.h"
#include "render/scene/view_tiles.h"

namespace ulf::render {

struct GlRendererState {
  std::shared_ptr<const RenderScene> plain;  // the scene with its own proxy
  std::shared_ptr<const RenderScene> scene;  // the same, or with the aperture's focal plane as proxy
  RenderOptions options;
  GlContext context;

  GlPhotographs photographs;
  GlViews views;
  GlProxy proxy;
  GlShadowMaps shadow_maps;
  GlDepthMaps depth_maps;
  GlPrograms programs;
  GlProgram show;
  GlBuffer triangles, fans, batches, tiles, needed;
  GlTexelBuffer nearest_first;
  GlPixelCounter open_px;
  ViewTiler tiler;
  std::shared_ptr<const TriangleMesh> proxy_triangles;  // in the current picture, or in the last one
  GlEmptyVertexArray no_vertices;
  GlDepth depth;
  GlTarget drawn{GL_RGBA32F}, confidence{GL_RG32F}, resolved{GL_RGBA32F}, shown{GL_RGBA8};
  bool has_triangles = false;    // of the proxy
  bool programs_stale = false;   // must be built again
  std::vector<bool> gaps_known;  // by view: its photograph was searched for pixels without light

  // State of the current picture, or of the last one: its camera, all levels offered, whether some are
  // missing (`lacks`), and whether a pass used coarser levels than are resident now (`outdated`).
  CameraModel camera;
  Rigid3 cam_from_world;
  PlaneInCamera plane;  // the proxy's background
  Eigen::Vector3d virtual_center = Eigen::Vector3d::Zero();
  std::vector<GlPhotographs::LevelRequest> offered;
  bool lacks = false, outdated = false;
  bool is_resolved = false;  // except for pixels that other views fill
  bool warned_of_passes = false;
  bool drew_lumigraph_pixels = false;  // at least once

  std::shared_ptr<const MeshField> mesh_field;
  EntryTable mesh_entries;
  std::unique_ptr<ApertureField> aperture_field;  // null without an aperture or a mesh

  GlRendererState(std::shared_ptr<const RenderScene> the_scene, const RenderOptions& the_options,
                  GlContextKind kind)
      : plain(std::move(the_scene)),
        scene(the_options.aperture ? WithFocalPlane(*plain, *the_options.aperture) : plain),
        options(the_options),
        context(kind),
        tiler(plain->views) {}

  void Build();
  void MakeMeshField();
  void SetCommon(const GlProgram& program) const;
  TriangleBatch MeshTriangles(const PlacedMesh& placed, const CameraModel& camera,
                              const Rigid3& cam_from_world) const;
  TriangleBatch RingTriangles(const PlacedMesh& placed, const CameraModel& camera,
                              const Rigid3& cam_from_world) const;
  std::unique_ptr<PlacedField> FieldFrom() const;
  DepthAt DepthOfVertices() const;
  TriangleBatch LumigraphTriangles() const;
  bool ProvideShadowMaps(std::span<const int> of_views);
  int NearestOf(std::span<const int> of_views) const;
  std::size_t MakeResident(std::span<const int> of_views);
  using DrawSome = std::function<void(std::size_t first, std::size_t end, int arrays)>;
  void ForResidentViews(const std::vector<int>& of_views, const DrawSome& draw);
  std::vector<int> MarkedViews(const GlProgram& mark, const std::vector<int>& candidates,
                               const std::function<void()>& draw);
  ViewTiles TilesFor(const std::vector<int>& in_order, bool marks);
  Filling filling() const;
  int FillingViewCount() const;
  void SetFill(const GlProgram& program) const;
  std::size_t SetTiles(const ViewTiles& of_views);
  bool FindGaps(const std::vector<int>& of_views);
  std::vector<int> FillingViews();
  void SetLumigraph(const GlProgram& program) const;
  bool AreResident(const std::vector<int>& of_views) const;
  void DrawLumigraphPixels();
  void DrawSoftPixels();
  void DrawMesh();
  using DrawPass = std::function<void(const FanBatches& of_pass, bool are_all)>;
  void ForResidentFans(const std::vector<GpuFan>& of_fans, const DrawPass& draw);
  void Upload(const FanBatches& some);
  void DrawFanBatches(const FanBatches& some, bool direct);
  void DrawBatch(const TriangleBatch& batch, bool more_follow);
  void AddRings(const TriangleBatch& rings);
  void BindForAdding();
  void ClearResolved();
  void SetResolve(const GlProgram& program) const;
  void Normalise();
  bool HasOpenPixels();
  void FillOpenPixels();
  void Resolve();
  cv::Mat Depth() const;  // of the last picture's pixels, CV_32F
};

}  // namespace ulf::render
