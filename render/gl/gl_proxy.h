// Draws the depths of the proxy's triangles, before anything is blended. The context must be current.
#pragma once

#include <memory>
#include <vector>

#include "render/gl/gl_objects.h"
#include "render/scene/scene.h"

namespace ulf::render {

class GlProxy {
 public:
  // Compiles the shaders; throws Error if the driver cannot.
  void Build();

  // Draws `mesh` into an image of depths along the optical axis, world units, and fills its holes from the
  // depths around them (as FillHoles() of depth_raster.h); all are 0 if nothing of the mesh is drawn. Points
  // nearer than kNearShare times `usual_depth` are not drawn.
  void Draw(const std::shared_ptr<const TriangleMesh>& mesh, const CameraModel& camera,
            const Rigid3& cam_from_world, double usual_depth);
  void BindDepth(unsigned unit) const { depth_.BindTexture(unit); }
  cv::Mat ReadDepth() const;  // CV_32F

  void Release();

 private:
  void FillHoles();

  GlProgram program_, pull_, push_;
  GlBuffer vertices_, corners_;
  GlEmptyVertexArray no_vertices_;
  std::shared_ptr<const TriangleMesh> uploaded_;
  GlDepth nearness_;
  GlTarget depth_{kDepthFormat};
  std::vector<GlTarget> coarser_;  // inverse depths, each half the size of the previous one
  cv::Size size_;

  static const unsigned kDepthFormat;
};

}  // namespace ulf::render
