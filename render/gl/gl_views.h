// The recorded views as shaders know them for one picture: where they stand as seen from the virtual camera,
// and where on the graphics side their photographs are.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/gl/gl_objects.h"
#include "render/gl/gl_photographs.h"
#include "render/gl/gl_shadow_maps.h"
#include "render/gl/gl_triangles.h"
#include "render/scene/scene.h"

namespace ulf::render {

class GlViews {
 public:
  // Texture units 0 to kMostArrays - 1 are the photographs'.
  static constexpr int kMostArrays = 9;
  static constexpr unsigned kUnit = 9;

  void Build(const RenderScene& scene);
  // For a picture's camera; photographs and shadow maps are nowhere yet.
  void Place(const RenderScene& scene, const CameraModel& camera, const Rigid3& cam_from_world);
  // Of the last Place(): what is to be read of each view.
  std::vector<GlPhotographs::LevelRequest> LevelRequests(std::span<const int> views) const;

  // Tells the shaders where the photographs of `views` are and that all others are nowhere. Together they lie
  // in no more than kMostArrays arrays: told are the first so many views, and how many is said. Of `arrays`
  // the n-th is what the shaders call array n.
  std::size_t SetPlaces(std::span<const int> views, const GlPhotographs& photographs,
                        std::vector<unsigned>& arrays);
  // For shaders that read no photograph, and those that read one array at a time.
  void SetPlaces(const GlPhotographs& photographs);

  // Tells the shaders where the views' shadow maps are; without one nothing is hidden from a view.
  void SetShadowMaps(const GlShadowMaps& shadow_maps);
  // Where all views have one camera: what a program needs to know of it, and of the exposure of the first.
  void SetOneCamera(const GlProgram& program) const;

  // Its photograph has pixels without light. Told to the shaders with the next that is told.
  void SetGaps(int view);

  void Release();

 private:
  // As in the shaders, a texel each.
  struct GpuView {
    Vec4 row0, row1, row2, intrinsics, size, k, more, color, center, shadow_map, place;
  };
  void Upload();

  std::vector<double> trusted_extent_;
  std::vector<Vec4> shadow_map_;
  std::vector<int> level_;
  std::vector<bool> has_gaps_;
  std::vector<GpuView> gpu_views_;
  GlTexelBuffer views_;
};

}  // namespace ulf::render
