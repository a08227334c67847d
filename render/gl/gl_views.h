// The recorded views as the shaders see them for one picture: their poses relative to the virtual camera, and
// the texture layers of their photographs. The context must be current.
#pragma once

#include <span>
#include <vector>

#include "render/gl/gl_depth_maps.h"
#include "render/gl/gl_objects.h"
#include "render/gl/gl_photographs.h"
#include "render/gl/gl_shadow_maps.h"
#include "render/gl/gl_triangles.h"
#include "render/scene/scene.h"

namespace ulf::render {

class GlViews {
 public:
  // The photographs use the texture units 0 to kMostArrays - 1; the views' data use kUnit.
  static constexpr int kMostArrays = 9;
  static constexpr unsigned kUnit = 9;

  void Build(const RenderScene& scene);  // comes first
  // Sets a picture's camera; photographs and shadow maps have no layers yet.
  void Place(const RenderScene& scene, const CameraModel& camera, const Rigid3& cam_from_world);
  // Returns the levels of these views that the picture of the last Place() reads.
  std::vector<GlPhotographs::LevelRequest> LevelRequests(std::span<const int> views) const;

  // Sets the layers of the photographs of the first views in `views` whose textures fit into kMostArrays
  // arrays, and returns how many these are; all other views have none. `arrays` are in the shaders' order.
  std::size_t SetPlaces(std::span<const int> views, const GlPhotographs& photographs,
                        std::vector<unsigned>& arrays);
  // Sets the layers alone, of all views, for shaders that read no photograph, or one array at a time.
  void SetPlaces(const GlPhotographs& photographs);

  // Sets the layers of the views' shadow maps; nothing is hidden from a view without a map.
  void SetShadowMaps(const GlShadowMaps& shadow_maps);
  // Sets the layers of the views' depth maps and the scale of the maps' values.
  void SetDepthMaps(const RenderScene& scene, const GlDepthMaps& depth_maps);
  // If all views have one camera, sets its uniforms and the first view's exposure.
  void SetOneCamera(const GlProgram& program) const;

  // Marks that the view's photograph has pixels without light. The shaders see it after the next Set...().
  void SetGaps(int view);

  void Release();

 private:
  // The shaders' struct View, a texel for each member.
  struct GpuView {
    Vec4 row0, row1, row2, intrinsics, size, k, more, color, center, shadow_map, place, correction,
        map_intrinsics, map_more;
  };
  void Upload();

  std::vector<double> distortion_extent_;
  std::vector<Vec4> shadow_map_;
  std::vector<int> level_;
  std::vector<bool> has_gaps_;
  std::vector<GpuView> gpu_views_;
  GlTexelBuffer views_;
};

}  // namespace ulf::render
